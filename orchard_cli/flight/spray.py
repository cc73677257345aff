"""When the pump may run: on the spray line, at spray speed, and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from orchard_cli.model.mission import Mission
from orchard_cli.model.vehicle import VehicleState

from .safety import Phase

LINE_TOLERANCE = 0.4  # m beside the row's line
SPEED_TOLERANCE = 0.25  # share of the spray speed


@dataclass(frozen=True, slots=True)
class Spray:
    """Whether to spray, on which row, and why (not)."""

    on: bool
    row: int | None
    why: str


def spray(mission: Mission, phase: Phase, vehicle: VehicleState, empty: bool = False) -> Spray:
    """Judge by where the vehicle is and how fast it goes, not by where it should be."""
    if phase is not Phase.ROUTE:
        return Spray(False, None, f"no spray in {phase.value}")
    if empty:
        return Spray(False, None, "the tank is empty")
    position, velocity = vehicle.position_site[:2], vehicle.velocity_site[:2]
    for segment, line in mission.spray_lines:
        for first, last in pairwise(line[:, :2]):
            length = float(np.linalg.norm(last - first))
            along = (last - first) / length
            offset = position - first
            s = float(offset @ along)
            beside = float(abs(offset[0] * along[1] - offset[1] * along[0]))
            if beside > LINE_TOLERANCE or not 0.0 <= s <= length:
                continue
            speed = float(velocity @ along)  # backwards is the way home, over what is done
            if abs(speed - mission.limits.speed) > SPEED_TOLERANCE * mission.limits.speed:
                return Spray(False, segment.row, "not at spray speed")
            return Spray(True, segment.row, "on the row")
    return Spray(False, None, "off the rows")
