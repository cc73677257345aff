"""Turning the nose: a yaw that never steps, within a rate and an acceleration."""

from __future__ import annotations

import math

from orchard_cli.model.trajectory import Trajectory

STANDING = 0.05  # m: below this the way ahead has no direction


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


def heading_ahead(trajectory: Trajectory, time: float, ahead: float) -> float | None:
    """Direction from where the trajectory is at `time` to where it is `ahead` s later, rad.

    None when it hardly moves in between: the nose then stays as it is.
    """
    here = trajectory.at(time).position_site
    there = trajectory.at(time + ahead).position_site
    dx, dy = float(there[0] - here[0]), float(there[1] - here[1])
    return math.atan2(dy, dx) if math.hypot(dx, dy) > STANDING else None
