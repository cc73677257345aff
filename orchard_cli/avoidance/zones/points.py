"""The points of an avoidance path (Wang 2020, §3.6, Fig. 6, eqs. 3-8).

Earth axes as published: x east, y north, and a course that is counted from north, clockwise. Any
right-handed pair of level axes will do when the course is counted from its second axis towards its
first.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from orchard_cli.model.arrays import Vector


class Way(Enum):
    """Past an obstacle."""

    LEFT = "left"
    RIGHT = "right"
    OVER = "over"


@dataclass(frozen=True, slots=True, eq=False)
class AvoidancePoints:
    """P_1 before the obstacle, P_2 beside or above it, P_3 behind it, each (3,) m."""

    before: Vector
    beside: Vector
    behind: Vector


def avoidance_points(
    before: Vector, course: float, way: Way, offset: float, reach: float
) -> AvoidancePoints:
    """P_2 and P_3 from P_1, the `course` (rad from y towards x) and the `offset` to fly (m, > 0):
    d_x to the side, or d_z up.

    `reach` is d, from P_1 to the obstacle's axis: 2 + w_o / 2. Of eqs. 7 and 8 print has lost all
    but the heights; the level parts are those of eqs. 3 to 6 with d_x = 0.
    """
    x1, y1, z1 = before
    if way is Way.OVER:
        step = reach * np.array([math.sin(course), math.cos(course), 0.0])
        over = before + step + np.array([0.0, 0.0, offset])
        return AvoidancePoints(before, over, over + step - np.array([0.0, 0.0, offset]))
    beta = math.atan(offset / reach)
    leg = math.hypot(offset, reach)
    near, far = course - beta, math.pi / 2 - course - beta  # the two θ of each pair of equations
    outwards = (leg * math.sin(near), leg * math.cos(near))
    inwards = (leg * math.cos(far), leg * math.sin(far))
    first, second = (outwards, inwards) if way is Way.LEFT else (inwards, outwards)
    beside = np.array([x1 + first[0], y1 + first[1], z1])
    behind = np.array([beside[0] + second[0], beside[1] + second[1], z1])
    return AvoidancePoints(before, beside, behind)


def clear_offset(aside: float, reach: float, keep: float) -> float | None:
    """The offset, m, at which the legs to and from P_2 keep `keep` m from the obstacle's axis.

    `aside`: m by which the axis lies off the course, + on the side on which it is passed. As
    published, P_2 alone keeps its distance (aside + keep); with a wide obstacle the legs pass
    nearer. None when P_1 is so near that no leg is clear.
    """
    if keep >= 0.95 * reach:
        return None
    leg = math.sqrt(reach**2 - keep**2 + aside**2)
    return (aside * reach**2 + keep * reach * leg) / (reach**2 - keep**2)
