"""The vehicles that can be simulated: airframe, battery, and the autopilot set up for them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from .autopilot.battery import Pack
from .body import X500, Airframe, sprayer

RATE_LOOP = 11.6  # rad/s: as well damped behind a lag of 50 ms as the X500's behind its 20 ms


@dataclass(frozen=True, slots=True)
class Kit:
    """One vehicle as it takes off."""

    name: str = "X500"
    airframe: Airframe = X500
    pack: Pack = field(default_factory=Pack)
    parameters: dict[str, float] = field(default_factory=dict)  # PX4's, set up for it
    level: float = 0.0  # of the tank at take-off

    def pack_for(self, endurance: float) -> Pack:
        """The battery that hovers this vehicle for `endurance` s as it takes off.

        A pack's own endurance is without a load; hover power goes with weight to the 3/2.
        """
        heavier = float(self.airframe.load(self.level)[0]) / self.airframe.mass
        return replace(self.pack, endurance=endurance * heavier**1.5)


SPRAYER_PACK = Pack(endurance=2400.0, capacity=30.0)
"""Empty; with a full tank a quarter of that, ten minutes, as plant protection vehicles have."""


def kit(vehicle: str, level: float = 0.0) -> Kit:
    """x500 or sprayer. Raises ValueError for another."""
    if vehicle == "x500":
        return Kit()
    if vehicle != "sprayer":
        raise ValueError(f"no vehicle {vehicle!r}")
    airframe = sprayer()
    return Kit("sprayer", airframe, SPRAYER_PACK, tuned(airframe, level), level)


def tuned(airframe: Airframe, level: float) -> dict[str, float]:
    """What a crew sets for the load at take-off: hover thrust, and rate gains for the inertia."""
    mass, roll_inertia = airframe.load(level)[:2]
    hover = mass / airframe.mass * airframe.hover_share
    torque = math.sqrt(0.5) * airframe.arm * airframe.thrust_max  # N m per unit of the mixer
    gain = RATE_LOOP * float(roll_inertia) / torque
    axes = {
        f"MC_{axis}RATE_{term}": share * gain
        for axis in ("ROLL", "PITCH")
        for term, share in (("P", 1.0), ("I", 1.33), ("D", 0.02))
    }
    return {"MPC_THR_HOVER": float(hover), "MC_ROLL_P": 3.0, "MC_PITCH_P": 3.0, **axes}
