"""The Π: spray lines in flight order, joined on the headlands (Liu 2024, §5.2, §6.2)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from orchard_cli.model.arrays import Points, Vector
from orchard_cli.model.mission import Leg, Limits
from orchard_cli.model.site import Orchard
from orchard_cli.model.terrain import Terrain
from orchard_cli.model.wishes import (
    Direction,
    FlightWishes,
    HeightAbove,
    Pattern,
    StartRow,
    StartSide,
)

from .lines import Line, spray_lines
from .turns import turn, way_back

HEADLAND = 4.0
"""m outside the rows where the flight starts and ends; more where full speed needs more room."""

EASE_IN = 1.0  # s at full speed: what the easing of the acceleration adds to the run-up
_SAME = 1e-6  # m
_BESIDE = 0.1  # m: less is the same line
_SPARE = 0.3  # m above the clearance where a turn would be lower


@dataclass(frozen=True, slots=True, eq=False)
class Pass:
    """A spray line as it is flown."""

    row: int  # index into Orchard.rows
    points_site: Points  # (k, 3) m, k >= 2, in flight order

    @property
    def length(self) -> float:
        """m along it."""
        return length(self.points_site)


@dataclass(frozen=True, slots=True)
class Stretch:
    """A part of a route: what it is for, and the waypoint at which it ends."""

    leg: Leg
    row: int | None
    until: int


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """Waypoints of the Π, and what the ways between them are for."""

    waypoints_site: Points  # (n, 3) m
    stretches: tuple[Stretch, ...]


def passes(orchard: Orchard, wishes: FlightWishes) -> list[Pass]:
    """Every spray line in flight order and direction."""
    lines = spray_lines(orchard, wishes)
    if wishes.start_row is StartRow.LAST:
        lines.reverse()
    if wishes.pattern is Pattern.ALTERNATE:
        lines = lines[::2]
    elif wishes.pattern is Pattern.OUT_AND_BACK:
        lines = lines[::2] + lines[1::2][::-1]
    forwards = wishes.start_side is StartSide.NEAR
    serpentine = wishes.direction is Direction.BOTH
    return [
        _flown(line, forwards == (k % 2 == 0 or not serpentine)) for k, line in enumerate(lines)
    ]


def _flown(line: Line, forwards: bool) -> Pass:
    return Pass(line.row, line.points_site if forwards else line.points_site[::-1])


def route(flown: list[Pass], wishes: FlightWishes, terrain: Terrain | None = None) -> Route:
    """One pass after another, with the turns between them, above the terrain where it is known."""
    points = [flown[0].points_site]
    stretches = [Stretch(Leg.ROW, flown[0].row, len(flown[0].points_site) - 1)]
    reached = len(flown[0].points_site) - 1
    for before, after in pairwise(flown):
        last, first = before.points_site[-2:], after.points_site[:2]
        same_way = (last[1] - last[0])[:2] @ (first[1] - first[0])[:2] > 0
        if same_way and _in_line(last, first):
            between = np.empty((0, 3))
        else:
            between = (way_back if same_way else turn)(last, first, wishes)
            between = _above(terrain, between, wishes)
        between = _distinct(last[1], between, first[0])
        reached += len(between) + 1
        stretches.append(Stretch(Leg.TRANSIT if same_way else Leg.HEADLAND, None, reached))
        reached += len(after.points_site) - 1
        stretches.append(Stretch(Leg.ROW, after.row, reached))
        points += [between, after.points_site]
    return Route(np.concatenate(points), tuple(stretches))


def _above(terrain: Terrain | None, points: Points, wishes: FlightWishes) -> Points:
    """A turn's waypoints (m, 3), none lower over the ground than lines are, or than is kept."""
    if terrain is None:
        return points
    over_ground = wishes.height_above is HeightAbove.GROUND
    least = wishes.height if over_ground else wishes.limits.clearance + _SPARE
    z = np.maximum(points[:, 2], terrain.ground(points[:, :2]) + least)
    return np.column_stack([points[:, :2], z])


def _in_line(last: Points, first: Points) -> bool:
    """Whether a pass begins straight ahead of where the one before ends."""
    way = (last[1] - last[0])[:2] / np.linalg.norm((last[1] - last[0])[:2])
    off = (first[0] - last[1])[:2]
    return bool(way @ off > 0 and abs(way[0] * off[1] - way[1] * off[0]) < _BESIDE)


def _distinct(start: Vector, between: Points, end: Vector) -> Points:
    """Waypoints that differ from their neighbours."""
    kept: list[Vector] = [start]
    for point in between:
        if np.linalg.norm(point - kept[-1]) > _SAME and np.linalg.norm(point - end) > _SAME:
            kept.append(point)
    return np.array(kept[1:]).reshape(-1, 3)


def run_up(limits: Limits) -> float:
    """m of straight flight outside the rows in which full speed is reached and lost."""
    needed = limits.speed**2 / (2 * limits.acceleration_along) + EASE_IN * limits.speed
    return max(HEADLAND, needed)


def run_up_point(end: Vector, inner: Vector, limits: Limits) -> Vector:
    """(3,) m: outside the route's end (3,), in line with its row, and as steep."""
    way = end - inner
    point: Vector = end + way / np.linalg.norm(way) * run_up(limits)
    return point


def length(points: Points) -> float:
    """m along a polyline."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
