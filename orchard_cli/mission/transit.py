"""The ways from take-off to the first spray line and from the last one to landing.

The last stretch lies in line with the row, long enough to reach spray speed. Where trees or known
obstacles stand under the way there, it is flown high enough above them, and sinks in line with the
row.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import shapely

from orchard_cli.errors import Fault
from orchard_cli.model.arrays import Points, Vector
from orchard_cli.model.mission import Limits
from orchard_cli.model.site import Orchard
from orchard_cli.model.wishes import FlightWishes
from orchard_cli.motion.fit import rounded

from . import checks
from .route import run_up_point

SHARPEST = math.radians(175.0)  # turn between a row and the way to take-off or landing
_SLOPE = 0.5  # m down per m onwards
_ASIDE = 3.0  # m: a way that would turn back on itself makes a step to the side
_SPARE = 0.05  # m above the clearance
_MICRONS = 6


def way(
    site: Vector | None, end: Vector, inner: Vector, orchard: Orchard, wishes: FlightWishes
) -> Points:
    """(n, 3) m from above `site` (2,) to a row's end, smooth; reversed, the way from there.

    Without a site it begins where the run-up does.
    """
    run = run_up_point(end, inner, wishes.limits)
    if site is None:
        corners = [run, end]
    else:
        corners = _over(np.asarray(site), run, end, orchard, wishes.limits)
    corners = [corners[0]] + [b for a, b in pairwise(corners) if np.linalg.norm(b - a) >= 1e-3]
    return np.round(rounded(np.array(_unfolded(corners)), wishes.corner_cut).points_site, _MICRONS)


def _over(site: Vector, run: Vector, end: Vector, orchard: Orchard, limits: Limits) -> list[Vector]:
    """Corners from a site to the end of a row, above all that stands on the way."""
    high = _clear_height(site, run[:2], orchard, limits)
    if high - _SPARE <= run[2]:  # at the row's own height all of it is clear
        return [np.array([*site, run[2]]), run, end]
    out = (run - end)[:2] / np.linalg.norm((run - end)[:2])
    top = run
    for _ in range(3):  # the longer descent may lead over something higher
        top = np.array([*(run[:2] + out * (high - run[2]) / _SLOPE), high])
        higher = max(
            _clear_height(site, top[:2], orchard, limits),
            _clear_height(top[:2], run[:2], orchard, limits),
        )
        if higher <= high:
            break
        high = higher
    return [np.array([*site, high]), top, run, end]


def _clear_height(a: Vector, b: Vector, orchard: Orchard, limits: Limits) -> float:
    """z, m, that keeps the clearance to all that stands under the way between two places (2,)."""
    line = shapely.LineString([a, b])
    highest = -math.inf
    for row in orchard.rows:
        under = shapely.distance(line, shapely.points(row.trunks_site)) < (
            checks.CANOPY_REACH + limits.clearance
        )
        highest = max(highest, float(row.canopy_tops_site[under].max(initial=-math.inf)))
    for obstacle in orchard.obstacles:
        beside = line.distance(shapely.Point(obstacle.position_site)) - obstacle.radius
        if beside < limits.clearance:
            highest = max(highest, obstacle.top)
    if orchard.terrain is not None:
        steps = np.linspace(0.0, 1.0, math.ceil(2 * line.length / orchard.terrain.step) + 2)
        under = orchard.terrain.ground(a + steps[:, None] * (b - a))
        highest = max(highest, float(under.max()))
    return highest + limits.clearance + _SPARE


def _unfolded(corners: list[Vector]) -> list[Vector]:
    """The corners with a step aside before each that turns straight back."""
    told = [corners[0]]
    for k in range(1, len(corners)):
        point = corners[k]
        if k + 1 < len(corners):
            into, out = (point - told[-1])[:2], (corners[k + 1] - point)[:2]
            if turn_between(into, out) > SHARPEST:
                left = np.array([-into[1], into[0], 0.0]) / np.linalg.norm(into)
                told.append(point + _ASIDE * left)
        told.append(point)
    return told


def turn_between(a: Vector, b: Vector) -> float:
    """Angle between two (2,) vectors, rad; 0 when one has no length."""
    cross = a[0] * b[1] - a[1] * b[0]
    return abs(math.atan2(float(cross), float(a @ b))) if a.any() and b.any() else 0.0


def end_faults(wishes: FlightWishes, waypoints: Points) -> list[Fault]:
    """Take-off or landing wished on the row's own line: the way there would turn back on itself."""
    faults = []
    for name, site, end, inner in (
        ("takeoff_m", wishes.takeoff_site, waypoints[0], waypoints[1]),
        ("landing_m", wishes.landing_site, waypoints[-1], waypoints[-2]),
    ):
        run = run_up_point(end, inner, wishes.limits)
        if site is not None and turn_between(site - run[:2], run[:2] - end[:2]) > SHARPEST:
            faults.append(
                Fault(
                    f"flight.{name}",
                    "lies inside the row's line: the vehicle would turn back on itself",
                    f"move it outwards, to ({run[0]:.1f}, {run[1]:.1f}) say, or leave it out",
                )
            )
    return faults
