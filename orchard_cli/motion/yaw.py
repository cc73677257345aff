"""Turning the nose: where to, and how fast."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from orchard_cli.model.trajectory import Trajectory

YAW_ACCELERATION = 0.6  # rad/s², of the steady rule
STANDING = 0.05  # m: below this the way ahead has no direction
PUBLISHED_RATE = math.pi  # rad/s, of EGO-Planner's rule

Turn = Callable[[float, float, float, float, float], tuple[float, float]]
"""(yaw, rate, target, dt, rate limit) -> (yaw, rate) `dt` s later, rad and rad/s."""


@dataclass(frozen=True, slots=True)
class YawRule:
    """To which place ahead the nose points, and how it is turned there."""

    ahead: float  # s: to where the vehicle will be then
    standing: float  # m: nearer than this, that place has no direction
    turn: Turn


def wrapped(angle: float) -> float:
    """The same angle in (-π, π]."""
    return math.atan2(math.sin(angle), math.cos(angle))


def step_yaw(
    yaw: float, rate: float, target: float, dt: float, rate_limit: float, acceleration: float
) -> tuple[float, float]:
    """Turn from `yaw` towards `target` for `dt` s the short way: (yaw, rate), rad and rad/s.

    The rate rises and falls by at most `acceleration` rad/s² and is chosen so that it can always
    still be brought to zero at the target: no overshoot.
    """
    error = wrapped(target - yaw)
    braking = math.sqrt(2 * acceleration * abs(error))
    wanted = math.copysign(min(rate_limit, braking, abs(error) / dt), error)
    change = min(max(wanted - rate, -acceleration * dt), acceleration * dt)
    rate = min(max(rate + change, -rate_limit), rate_limit)
    return wrapped(yaw + rate * dt), rate


def step_steadily(
    yaw: float, rate: float, target: float, dt: float, rate_limit: float
) -> tuple[float, float]:
    """`step_yaw` with YAW_ACCELERATION: the yaw never steps."""
    return step_yaw(yaw, rate, target, dt, rate_limit, YAW_ACCELERATION)


def step_as_published(
    yaw: float, rate: float, target: float, dt: float, rate_limit: float
) -> tuple[float, float]:
    """EGO-Planner's rule (Zhou 2020, its trajectory server), whatever the mission's limit.

    At most PUBLISHED_RATE; then the mean with the yaw before, but not across the wrap at ±π; the
    rate is that of the change asked for, and then the mean with the rate before.
    """
    del rate_limit
    most = PUBLISHED_RATE * dt
    change = min(max(wrapped(target - yaw), -most), most)
    across = abs(yaw + change) > math.pi
    turned = wrapped(yaw + change) if across else yaw + change / 2
    return turned, (rate + change / dt) / 2


STEADY = YawRule(2.0, STANDING, step_steadily)
PUBLISHED = YawRule(1.0, 0.1, step_as_published)


def heading_ahead(
    trajectory: Trajectory, time: float, ahead: float, standing: float = STANDING
) -> float | None:
    """Direction from where the trajectory is at `time` to where it is `ahead` s later, rad.

    None when these are `standing` m apart or less: the nose then stays as it is.
    """
    here = trajectory.at(time).position_site
    there = trajectory.at(time + ahead).position_site
    dx, dy = float(there[0] - here[0]), float(there[1] - here[1])
    return math.atan2(dy, dx) if math.hypot(dx, dy) > standing else None
