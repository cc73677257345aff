"""Setpoints of the automatic modes: a point that glides to its target within limits.

PX4 limits jerk too (its trajectory library); this one keeps to the same speeds and accelerations
and so takes the same time within a few tenths of a second.
"""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Vector

from .seen import Seen

NEAR_GAIN = 1.5  # 1/s, closing speed per distance where the target is near


class Glide:
    """A virtual point with a velocity, ahead of the vehicle."""

    def __init__(self, seen: Seen) -> None:
        self.position = np.array(seen.position_site)
        self.velocity = np.array(seen.velocity_site)

    def towards(
        self,
        target: Vector,
        speed: float,
        climb: float,
        descent: float,
        accelerate: float,
        dt: float,
    ) -> None:
        """Move by `dt` towards `target`, the horizontal and the vertical each on its own."""
        dx, dy, dz = (target - self.position).tolist()
        far = math.hypot(dx, dy)
        pace = _closing(far, speed, accelerate) / far if far > 1e-9 else 0.0
        ax, ay = dx * pace - self.velocity[0], dy * pace - self.velocity[1]
        change = math.hypot(ax, ay)
        share = min(1.0, accelerate * dt / change) if change > 0 else 0.0
        self.velocity[0] += ax * share
        self.velocity[1] += ay * share
        up = math.copysign(_closing(abs(dz), climb if dz > 0 else descent, accelerate), dz)
        change = up - float(self.velocity[2])
        self.velocity[2] += math.copysign(min(abs(change), accelerate * dt), change)
        self.position += self.velocity * dt


def _closing(distance: float, speed: float, accelerate: float) -> float:
    """Speed at which a point `distance` m away is still reached at rest with half `accelerate`."""
    return min(speed, math.sqrt(accelerate * distance), NEAR_GAIN * distance)


def stopping_point(seen: Seen, accelerate: float) -> Vector:
    """Where the vehicle comes to rest when it brakes now, (3,) m."""
    v = seen.velocity_site
    reach = seen.speed / accelerate
    rise = abs(float(v[2])) / accelerate
    return np.asarray(seen.position_site + v * np.array([reach, reach, rise]))


class Heading:
    """A yaw that follows a wanted one within PX4's rate and acceleration for automatic modes."""

    def __init__(self, seen: Seen) -> None:
        self.yaw = seen.yaw_site
        self.rate = 0.0

    def towards(self, wanted: float, rate_max: float, accelerate: float, dt: float) -> None:
        """Turn by `dt` the short way towards `wanted`, radians."""
        miss = math.remainder(wanted - self.yaw, math.tau)
        pace = math.copysign(_closing(abs(miss), rate_max, accelerate), miss)
        change = pace - self.rate
        self.rate += math.copysign(min(abs(change), accelerate * dt), change)
        self.yaw = math.remainder(self.yaw + self.rate * dt, math.tau)
