"""Turns on the headland, outside the last trees: square, rounded, or a loop."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.wishes import FlightWishes, Turn

_STEP = math.radians(22.5)  # of an arc between two waypoints
_NONE = np.empty((0, 3))


def turn(before: Points, after: Points, wishes: FlightWishes) -> Points:
    """Waypoints (m, 3) m between the last two points of one line (2, 3) and the first of the next.

    The lines are flown towards and away from the same side. A square turn without headland is the
    paper's: straight from the last tree to the next row's.
    """
    if wishes.turn is Turn.SQUARE and wishes.headland == 0:
        return _NONE
    into, out = _way(before), _way(after)
    outwards = (into - out) / np.linalg.norm(into - out)
    line = max(before[1, :2] @ outwards, after[0, :2] @ outwards) + wishes.headland
    start = _reached(before[1], into, outwards, float(line))
    end = _reached(after[0], -out, outwards, float(line))
    if wishes.turn is Turn.SQUARE:
        return np.array([start, end])
    plan = _arcs(start[:2], end[:2], outwards, wishes)
    z = np.interp(_lengths(plan), [0.0, float(_lengths(plan)[-1])], [start[2], end[2]])
    return np.column_stack([plan, z])


def way_back(before: Points, after: Points, wishes: FlightWishes) -> Points:
    """Waypoints (m, 3) m from the end of a line back to the start of the next, flown the same way.

    The way back lies midway between the two lines; its turns are those of `turn`.
    """
    into = _way(before)
    left = np.array([-into[1], into[0]])
    beside = float((after[0, :2] - before[1, :2]) @ left) / 2
    high = max(before[1, 2], after[0, 2])
    lane = np.array(
        [
            [*(before[1, :2] + left * beside), high],
            [*(after[0, :2] - left * beside), high],
        ]
    )
    return np.concatenate([turn(before, lane, wishes), lane, turn(lane, after, wishes)])


def _way(points: Points) -> Vector:
    """Direction of flight seen from above, (2,)."""
    way = points[1, :2] - points[0, :2]
    return np.asarray(way / np.linalg.norm(way))


def _reached(end: Vector, way: Vector, outwards: Vector, line: float) -> Vector:
    """The point (3,) m on the way onwards from a row's end where the turn begins."""
    further = (line - end[:2] @ outwards) / (way @ outwards)
    return np.array([*(end[:2] + further * way), end[2]])


def _arcs(start: Vector, end: Vector, outwards: Vector, wishes: FlightWishes) -> Points:
    """A half circle; or, where that is tighter than the wished radius, a loop that swings out."""
    apart = float(np.linalg.norm(end - start))
    across = (end - start) / apart
    out = outwards - (outwards @ across) * across
    out = out / np.linalg.norm(out)
    middle, radius = (start + end) / 2, apart / 2
    if wishes.turn is Turn.ROUNDED or wishes.turn_radius <= radius:
        return _arc(middle, radius, across, out, 0.0, math.pi)
    radius = wishes.turn_radius
    swing = math.acos((apart / 2 + radius) / (2 * radius))
    top = middle + out * 2 * radius * math.sin(swing)
    away = _arc(start - across * radius, radius, -across, out, 0.0, swing)
    round_ = _arc(top, radius, across, out, -swing, math.pi + swing)
    back = _arc(end + across * radius, radius, across, out, swing, 0.0)
    return np.concatenate([away, round_[1:-1], back])


def _arc(
    centre: Vector, radius: float, across: Vector, out: Vector, begin: float, end: float
) -> Points:
    """Points (n, 2) m; at angle 0 they lie against `across`, at a right angle along `out`."""
    count = max(2, math.ceil(abs(end - begin) / _STEP - 1e-9) + 1)
    angles = np.linspace(begin, end, count)[:, None]
    return np.asarray(centre + radius * (out * np.sin(angles) - across * np.cos(angles)))


def _lengths(points: Points) -> Array:
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])
