"""Where to fly past one obstacle."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Points, Vector
from orchard_cli.model.mission import Limits
from orchard_cli.motion.course import smooth
from orchard_cli.motion.path import Path

from .decide import Ahead
from .points import AvoidancePoints, Way, avoidance_points, clear_offset
from .settings import ZonesSettings

_ROUNDS = 4  # of moving P_2 out by what rounding cuts off
_STEEPEST = 0.6  # sine of the angle between a leg and the course
_SOON = 0.3  # m after the place where a change may begin


def points_past(
    path: Path, one: Ahead, way: Way, begin: float, limits: Limits, s: ZonesSettings
) -> Points | str:
    """P_1, P_2 and P_3, each a row of (n, 3) m, past an obstacle on a path; or why there are none.

    `begin`: m along the path to where a change may begin. P_1 is `approach` m before the obstacle's
    surface; earlier before a wide one, whose legs would be steep; later where that is past.
    """
    keep = one.obstacle.width / 2 + s.half + s.spare
    wanted = max(one.obstacle.width / 2 + s.approach, keep / _STEEPEST)
    start = max(one.along - wanted, begin + _SOON)
    reach = one.along - start
    if reach <= one.obstacle.width / 2:
        return "it is abeam already"
    before, behind = path.at(start), path.at(start + 2 * reach)
    course = math.atan2(behind[0] - before[0], behind[1] - before[1])
    ends = np.stack([path.at(start - reach), path.at(start + 3 * reach)])
    if way is Way.OVER:
        return _over(one, before, course, reach, ends, limits, s)
    return _round(one, way, before, course, reach, ends, s)


def _round(
    one: Ahead,
    way: Way,
    before: Vector,
    course: float,
    reach: float,
    ends: Points,
    s: ZonesSettings,
) -> Points | str:
    """P_2 is moved out until the rounded path keeps the passing area from the obstacle."""
    aside = one.aside if way is Way.LEFT else -one.aside
    keep = one.obstacle.width / 2 + s.half + s.spare
    offset = clear_offset(aside, reach, keep)
    if offset is None:
        return "it is too near to go round"
    outwards = np.array([math.cos(course), -math.sin(course)])
    aim = offset
    for _ in range(_ROUNDS):
        if aim > s.furthest:
            return f"the way round leads {aim:.1f} m off the route"
        points = _rows(avoidance_points(before, course, way, aim, reach))
        bow = smooth(np.vstack([ends[0], points, ends[1]]))
        aim += offset - float(np.abs((bow[:, :2] - before[:2]) @ outwards).max())
    return points


def _over(
    one: Ahead,
    before: Vector,
    course: float,
    reach: float,
    ends: Points,
    limits: Limits,
    s: ZonesSettings,
) -> Points:
    """P_2 becomes two, above the obstacle's near and far end: as published, a straight climb to
    above its middle passes too near to the end of a box."""
    offset = -one.d_z(limits.clearance) + s.spare
    along = np.array([math.sin(course), math.cos(course), 0.0])
    half = one.obstacle.width / 2 * along
    aim = offset
    for _ in range(_ROUNDS):
        rows = _rows(avoidance_points(before, course, Way.OVER, aim, reach))
        points = np.stack([rows[0], rows[1] - half, rows[1] + half, rows[2]])
        bow = smooth(np.vstack([ends[0], points, ends[1]]))
        over = np.abs((bow - rows[1]) @ along) <= one.obstacle.width / 2
        if not over.any():
            break
        aim += offset - float((bow[over, 2] - before[2]).min())
    return points


def _rows(points: AvoidancePoints) -> Points:
    return np.stack([points.before, points.beside, points.behind])
