"""When the pump may run: on the spray line, at spray speed, and nowhere else."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from orchard_cli.model.mission import Mission
from orchard_cli.model.vehicle import VehicleState

from .safety import Phase

LINE_TOLERANCE = 0.4  # m beside the row's line
SPEED_TOLERANCE = 0.25  # share of the speed that is planned for the row


class Line(NamedTuple):
    """One straight piece of a row's line; plain numbers, for it is looked at 50 times a second."""

    row: int | None
    x: float  # m, of its begin
    y: float
    along_x: float  # unit vector to its end
    along_y: float
    length: float  # m
    speed: float  # m/s, as planned


@dataclass(frozen=True, slots=True)
class SprayLines:
    """Where a mission sprays, and how fast."""

    lines: tuple[Line, ...]

    @classmethod
    def of(cls, mission: Mission) -> SprayLines:
        """Those of a mission."""
        found = []
        for segment, points in mission.spray_lines:
            speed = mission.planned_speed(segment)
            for (x, y), (x1, y1) in pairwise(points[:, :2].tolist()):
                length = math.hypot(x1 - x, y1 - y)
                whole = max(length, 1e-9)
                along = (x1 - x) / whole, (y1 - y) / whole
                found.append(Line(segment.row, x, y, along[0], along[1], length, speed))
        return cls(tuple(found))


@dataclass(frozen=True, slots=True)
class Spray:
    """Whether to spray, on which row, and why (not)."""

    on: bool
    row: int | None
    why: str


def spray(lines: SprayLines, phase: Phase, vehicle: VehicleState, empty: bool = False) -> Spray:
    """Judge by where the vehicle is and how fast it goes, not by where it should be."""
    if phase is not Phase.ROUTE:
        return Spray(False, None, f"no spray in {phase.value}")
    if empty:
        return Spray(False, None, "the tank is empty")
    (x, y, _), (vx, vy, _) = vehicle.position_site.tolist(), vehicle.velocity_site.tolist()
    for line in lines.lines:
        dx, dy = x - line.x, y - line.y
        beside = abs(dx * line.along_y - dy * line.along_x)
        if (
            beside > LINE_TOLERANCE
            or not 0.0 <= dx * line.along_x + dy * line.along_y <= line.length
        ):
            continue
        speed = vx * line.along_x + vy * line.along_y  # backwards is home, over what is done
        if abs(speed - line.speed) > SPEED_TOLERANCE * line.speed:
            return Spray(False, line.row, "not at spray speed")
        return Spray(True, line.row, "on the row")
    return Spray(False, None, "off the rows")
