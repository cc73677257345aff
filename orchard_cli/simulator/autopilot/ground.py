"""On and off the ground: PX4's take-off ramp and its land detector."""

from __future__ import annotations

import math
from enum import Enum

from orchard_cli.simulator.body._kernels import GRAVITY

from .parameters import Parameters
from .seen import Seen


class Lift(Enum):
    """PX4's take-off states."""

    DISARMED = 0
    SPOOLUP = 1
    READY = 2
    RAMPUP = 3
    FLIGHT = 4


class Takeoff:
    """From arming to flight: rotors spool up, then the climb limit grows from no thrust at all."""

    def __init__(self) -> None:
        self.lift = Lift.DISARMED
        self._armed_at = 0.0
        self._progress = 0.0

    def step(
        self, now: float, dt: float, armed: bool, landed: bool, wanted: bool, values: Parameters
    ) -> None:
        """Advance by a tick. `wanted`: the mode asks for a climb."""
        if not armed:
            self.lift = Lift.DISARMED
            return
        if self.lift is Lift.DISARMED:
            self.lift, self._armed_at = Lift.SPOOLUP, now
        if self.lift is Lift.SPOOLUP and now - self._armed_at >= values["COM_SPOOLUP_TIME"]:
            self.lift = Lift.READY
        if self.lift is Lift.READY and wanted:
            self.lift, self._progress = Lift.RAMPUP, 0.0
        if self.lift is Lift.RAMPUP:
            self._progress += dt / max(values["MPC_TKO_RAMP_T"], dt)
            if self._progress >= 1.0:
                self.lift = Lift.FLIGHT
        if self.lift is Lift.FLIGHT and landed:
            self.lift = Lift.READY

    def climb_limit(self, wanted: float, values: Parameters) -> float:
        """Greatest climb speed now, m/s. It starts where the velocity loop asks for no thrust."""
        if self.lift is Lift.FLIGHT:
            return wanted
        start = -GRAVITY / values["MPC_Z_VEL_P_ACC"]
        return start + (wanted - start) * (self._progress if self.lift is Lift.RAMPUP else 0.0)


class LandDetector:
    """PX4's MulticopterLandDetector: contact, maybe landed, landed, each held for HOLD."""

    HOLD = 1.0 / 3.0  # s

    def __init__(self) -> None:
        self.landed = True
        self.contact = True
        self._maybe = True
        self._since = [-math.inf] * 3

    def step(
        self, seen: Seen, armed: bool, thrust: float, sinking: bool, values: Parameters
    ) -> None:
        """Judge a tick. `thrust` is the collective, `sinking`: the mode asks to descend."""
        least, hover = values["MPC_THR_MIN"], values["MPC_THR_HOVER"]
        rising = abs(seen.climb) > values["LNDMC_Z_VEL_MAX"]
        moving = seen.speed > values["LNDMC_XY_VEL_MAX"]
        turning = seen.turning > math.radians(values["LNDMC_ROT_MAX"])
        low = thrust <= least + 0.3 * (hover - least)
        near = seen.height < values["LNDMC_ALT_GND"] or values["LNDMC_ALT_GND"] < 0
        contact = near and (low or sinking) and not rising and not moving
        self.contact = self._held(0, contact, seen.time)
        maybe = self.contact and thrust <= least + 0.1 * (hover - least) and not turning
        self._maybe = self._held(1, maybe, seen.time)
        self.landed = self._held(2, self._maybe, seen.time) or not armed

    def _held(self, stage: int, true: bool, now: float) -> bool:
        if not true:
            self._since[stage] = math.inf
        elif self._since[stage] == math.inf:
            self._since[stage] = now
        return now - self._since[stage] >= self.HOLD


class AutoDisarm:
    """PX4's two rules: some time after landing, and some time armed without taking off."""

    def __init__(self) -> None:
        self._since = 0.0
        self._flew = False

    def armed(self, now: float) -> None:
        """The vehicle was armed."""
        self._since, self._flew = now, False

    def due(self, now: float, landed: bool, values: Parameters) -> bool:
        """Whether to disarm an armed vehicle now. Call once per tick."""
        if not landed:
            self._since, self._flew = now, True
            return False
        limit = values["COM_DISARM_LAND" if self._flew else "COM_DISARM_PRFLT"]
        return limit > 0 and now - self._since >= limit
