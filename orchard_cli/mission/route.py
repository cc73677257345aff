"""The Π: waypoints above the first and the last tree of each row (Liu 2024, §5.2, §6.2)."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.mission import Limits
from orchard_cli.model.site import Orchard, TreeRow
from orchard_cli.model.wishes import FlightWishes, HeightAbove, StartRow, StartSide

HEADLAND = 4.0
"""m outside the rows where the flight starts and ends; more where full speed needs more room."""

EASE_IN = 1.0  # s at full speed: what the easing of the acceleration adds to the run-up


def row_order(orchard: Orchard, wishes: FlightWishes) -> list[tuple[int, bool]]:
    """Rows in flight order: (index into `orchard.rows`, flown along +x)."""
    indices = list(range(len(orchard.rows)))
    if wishes.start_row is StartRow.LAST:
        indices.reverse()
    forwards = wishes.start_side is StartSide.NEAR
    return [(row, forwards == (k % 2 == 0)) for k, row in enumerate(indices)]


def waypoints(orchard: Orchard, wishes: FlightWishes) -> Points:
    """(2 rows, 3) m: entry and exit of each row in flight order."""
    points = []
    for row, forwards in row_order(orchard, wishes):
        ends = _row_line(orchard.rows[row], wishes)
        points += [ends[0], ends[1]] if forwards else [ends[1], ends[0]]
    return np.array(points)


def _row_line(row: TreeRow, wishes: FlightWishes) -> Points:
    """(2, 3) m: the flight line's ends above the first and the last tree.

    The line is the lowest one that keeps the wished height over every tree of the row.
    """
    under = row.ground if wishes.height_above is HeightAbove.GROUND else row.canopy_tops_site
    along = np.linalg.norm(row.trunks_site - row.trunks_site[0], axis=1)
    z = lowest_line_over(along, under) + wishes.height
    return np.column_stack([row.trunks_site[[0, -1]], z])


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
