"""Does a flight fit its battery and its tank?"""

from __future__ import annotations

import numpy as np

from orchard_cli.errors import Fault
from orchard_cli.model.mission import Limits, Mission

_NEAR = 0.05  # l: how well what is stated must agree with what is sprayed


def battery_faults(energy_share: float, limits: Limits) -> list[Fault]:
    """A flight that would land with less than the reserve."""
    if energy_share <= 1 - limits.reserve:
        return []
    return [
        Fault(
            "battery",
            f"the flight takes {energy_share:.0%} of a {limits.endurance:.0f} s battery "
            f"and {limits.reserve:.0%} must be left",
            "split the orchard over several surveys, or fly faster",
        )
    ]


def tank_faults(mission: Mission) -> list[Fault]:
    """A flight that sprays more than the tank holds, or says that it sprays less than it does."""
    if mission.tank is None or mission.liquid is None:
        return []
    lines = mission.spray_lines
    seconds = sum(segment.end - segment.start for segment, _ in lines)
    metres = sum(float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum()) for _, p in lines)
    needed = mission.tank.litres(seconds, metres, mission.swath)
    faults = []
    if abs(needed - mission.liquid) > _NEAR:
        faults.append(Fault("liquid_l", "does not agree with what is sprayed", "plan it again"))
    if needed > mission.tank.capacity:
        faults.append(
            Fault(
                "tank",
                f"the flight sprays {needed:.2f} l and it holds {mission.tank.capacity:g} l",
                "split the orchard over several surveys, or spray less",
            )
        )
    return faults
