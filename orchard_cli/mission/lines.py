"""Spray lines over an orchard: above the rows or between them, one or more for each.

Liu 2024, §5.2 and §6.2 flies one line a row, above its first and last tree: that is the default.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.site import Orchard, TreeRow
from orchard_cli.model.terrain import Terrain
from orchard_cli.model.wishes import FlightWishes, FlyOver, Follow, HeightAbove
from orchard_cli.motion.straightening import straightened

_SAME = 1e-6  # m along a line: trees this near to each other are one place
_ON_ROW = 1e-9  # of the distance between two rows: nearer than this a line is above a row
_LEVEL = 0.02  # m by which a line that follows the terrain may be simplified


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """One spray line, from the side of the rows' first trees to the other."""

    row: int  # index into Orchard.rows of the row it treats; between two, of the first
    points_site: Points  # (k, 3) m, k >= 2


def spray_lines(orchard: Orchard, wishes: FlightWishes) -> list[Line]:
    """All lines of an orchard, across the rows."""
    return [_line(orchard, wishes, across) for across in _places_across(orchard, wishes)]


@dataclass(frozen=True, slots=True, eq=False)
class _Below:
    """What a line is flown over: rows of trees, and the terrain where it is known."""

    rows: list[TreeRow]
    terrain: Terrain | None


def _places_across(orchard: Orchard, wishes: FlightWishes) -> list[float]:
    """Where lines lie, counted in rows: 0 is above the first row, 0.5 midway to the second."""
    count = len(orchard.rows)
    if wishes.fly_over is FlyOver.BETWEEN:
        places = []
        for k in range(count - 1):
            n = _passes(wishes, _apart(orchard, k))
            places += [k + (j + 0.5) / n for j in range(n)]
        return places
    places = []
    for k in range(count):
        gaps = [_apart(orchard, g) for g in (k - 1, k) if 0 <= g < count - 1]
        n = _passes(wishes, max(gaps, default=wishes.swath))
        places += [k + ((j + 0.5) / n - 0.5) for j in range(n)]
    return places


def _apart(orchard: Orchard, k: int) -> float:
    """Greatest distance of row k from row k + 1, at their ends, m."""
    a, b = (orchard.rows[i].trunks_site[[0, -1]] for i in (k, k + 1))
    way = (a[1] - a[0]) / np.linalg.norm(a[1] - a[0])
    off = b - a
    return float(np.abs(way[0] * off[:, 1] - way[1] * off[:, 0]).max())


def _passes(wishes: FlightWishes, width: float) -> int:
    """Passes for one row, whose share of the field is `width` m wide."""
    if wishes.overlap is None:
        return wishes.passes
    return max(1, math.ceil(width / (wishes.swath * (1 - wishes.overlap)) - 1e-9))


def _line(orchard: Orchard, wishes: FlightWishes, across: float) -> Line:
    rows, count, terrain = orchard.rows, len(orchard.rows), orchard.terrain
    nearest = min(max(math.floor(across + 0.5 - _ON_ROW), 0), count - 1)
    if abs(across - nearest) < _ON_ROW:
        below = _Below([rows[nearest]], terrain)
        return Line(nearest, _above(below, rows[nearest].trunks_site[[0, -1]], wishes))
    if count == 1:
        a, b = rows[0].trunks_site[[0, -1]]
        left = np.array([a[1] - b[1], b[0] - a[0]]) / np.linalg.norm(b - a)
        width = wishes.swath * (1 - (wishes.overlap or 0.0))
        ends = np.array([a, b]) + left * across * wishes.passes * width
        return Line(0, _above(_Below([rows[0]], terrain), ends, wishes))
    first = min(max(math.floor(across), 0), count - 2)
    share = across - first
    a, b = (rows[k].trunks_site[[0, -1]] for k in (first, first + 1))
    beside = [rows[k] for k in (first, first + 1)] if 0 < share < 1 else [rows[nearest]]
    return Line(nearest, _above(_Below(beside, terrain), a + share * (b - a), wishes))


def _above(below: _Below, ends: Points, wishes: FlightWishes) -> Points:
    """(k, 3) m: a line between two places (2, 2), as high as wished over what is below."""
    way = ends[1] - ends[0]
    length = float(np.linalg.norm(way))
    trunks = np.concatenate([row.trunks_site for row in below.rows])
    canopy = wishes.height_above is HeightAbove.CANOPY
    under = np.concatenate([row.canopy_tops_site if canopy else row.ground for row in below.rows])
    along, tops = _merged((trunks - ends[0]) @ way / length, under)
    if wishes.follow is Follow.TERRAIN:
        return _followed(
            ends, *_highest(below.terrain, ends, along, _shoulders(tops, canopy)), wishes
        )
    along, tops = _highest(below.terrain, ends, along, tops)
    z = lowest_line_over(along, tops)
    slope = (z[1] - z[0]) / (along[-1] - along[0])
    z = z[0] + slope * (np.array([0.0, length]) - along[0])
    return np.column_stack([ends, z + wishes.height])


def _highest(
    terrain: Terrain | None, ends: Points, along: Array, tops: Array
) -> tuple[Array, Array]:
    """Places along a line with the higher of what stands beside it and of the ground below it."""
    if terrain is None:
        return along, tops
    length = float(np.linalg.norm(ends[1] - ends[0]))
    steps = np.linspace(0.0, length, math.ceil(2 * length / terrain.step) + 1)
    at = np.unique(np.concatenate([along, steps]))
    ground = terrain.ground(ends[0] + at[:, None] / length * (ends[1] - ends[0]))
    return _merged(
        np.concatenate([at, along]),
        np.concatenate([np.maximum(ground, np.interp(at, along, tops)), tops]),
    )


def _shoulders(tops: Array, canopy: bool) -> Array:
    """Over a tree as high as over its neighbours."""
    if not canopy:
        return tops
    padded = np.concatenate([tops[:1], tops, tops[-1:]])
    return np.asarray(np.maximum(np.maximum(padded[:-2], tops), padded[2:]))


def _merged(along: Array, tops: Array) -> tuple[Array, Array]:
    """Places along the line in order, each once, with the highest of what stands there."""
    order = np.argsort(along, kind="stable")
    along, tops = along[order], tops[order]
    begins = np.concatenate([[True], np.diff(along) > _SAME])
    starts = np.flatnonzero(begins)
    return along[starts], np.maximum.reduceat(tops, starts)


def _followed(ends: Points, along: Array, tops: Array, wishes: FlightWishes) -> Points:
    """Up and down with the ground or the canopies."""
    length = float(np.linalg.norm(ends[1] - ends[0]))
    inner = (along > _SAME) & (along < length - _SAME)
    at = np.concatenate([[0.0], along[inner], [length]])
    profile = np.column_stack([at, np.zeros(len(at)), np.interp(at, along, tops)])
    kept = straightened(profile, _LEVEL)
    places = ends[0] + kept[:, :1] / length * (ends[1] - ends[0])
    z = _held_up(kept[:, 0], kept[:, 2])
    return np.column_stack([places, z + wishes.height + _LEVEL * (len(kept) > 2)])


def _held_up(along: Array, z: Array) -> Array:
    """Heights whose ends sink outwards no steeper than the whole line: so does what lies beyond."""
    rise = (z[-1] - z[0]) / (along[-1] - along[0])
    held = z.copy()
    held[0] = max(z[0], z[1] + min(0.0, -rise) * (along[1] - along[0]))
    held[-1] = max(z[-1], z[-2] + min(0.0, rise) * (along[-1] - along[-2]))
    return held


def lowest_line_over(along: Array, tops: Array) -> Array:
    """Heights (2,) m at the first and last place of the lowest straight line over all `tops`.

    `along` is (n,) m, increasing. Lowest on average over the places: that line is the edge of the
    tops' upper hull above the mean place.
    """
    hull: list[int] = []
    for i in range(len(along)):
        while len(hull) > 1 and _is_under(hull[-1], hull[-2], i, along, tops):
            hull.pop()
        hull.append(i)
    at = int(np.clip(np.searchsorted(along[hull], along.mean()), 1, len(hull) - 1))
    a, b = hull[at - 1], hull[at]
    slope = (tops[b] - tops[a]) / (along[b] - along[a])
    return np.array([tops[a] + slope * (along[end] - along[a]) for end in (0, -1)])


def _is_under(middle: int, before: int, after: int, along: Array, tops: Array) -> bool:
    rise = (tops[after] - tops[before]) * (along[middle] - along[before])
    return bool((tops[middle] - tops[before]) * (along[after] - along[before]) <= rise)
