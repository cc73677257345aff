"""Setpoints of the automatic modes: a point that glides to its target within limits.

PX4's trajectory library keeps to the same speeds, accelerations and jerk by switching between
jerks; this one follows a closing speed, and takes the same time within a second.
"""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Vector

from .seen import Seen

NEAR_GAIN = 1.0  # 1/s, closing speed per distance where the target is near
FOLLOW_GAIN = 4.0  # 1/s, acceleration per missing speed


class Glide:
    """A virtual point with velocity and acceleration, ahead of the vehicle."""

    def __init__(self, seen: Seen) -> None:
        self.position = np.array(seen.position_site)
        self.velocity = np.array(seen.velocity_site)
        self.acceleration = np.zeros(3)

    def towards(
        self, target: Vector, speed: float, climb: float, descent: float,
        accelerate: float, jerk: float, dt: float,
    ) -> None:  # fmt: skip
        """Move by `dt` towards `target`, the horizontal and the vertical each on its own."""
        dx, dy, dz = (target - self.position).tolist()
        far = math.hypot(dx, dy)
        pace = _closing(far, speed, accelerate) / far if far > 1e-9 else 0.0
        up = math.copysign(_closing(abs(dz), climb if dz > 0 else descent, accelerate), dz)
        missing = np.array([dx * pace, dy * pace, up]) - self.velocity
        for axes in (slice(0, 2), slice(2, 3)):
            wanted = _pull(missing[axes], accelerate, jerk)
            self.acceleration[axes] += _shortened(wanted - self.acceleration[axes], jerk * dt)
        self.velocity += self.acceleration * dt
        self.position += self.velocity * dt


def _pull(missing: Vector, accelerate: float, jerk: float) -> Vector:
    """Acceleration for a missing speed that can be taken back in time within the jerk."""
    size = math.hypot(*missing)
    if size < 1e-9:
        return missing
    return missing * (min(accelerate, math.sqrt(jerk * size), FOLLOW_GAIN * size) / size)


def _shortened(vector: Vector, limit: float) -> Vector:
    size = math.hypot(*vector)
    return vector * (limit / size) if size > limit else vector


def _closing(distance: float, speed: float, accelerate: float) -> float:
    """Speed at which a point `distance` m away is reached at rest with a third of `accelerate`."""
    return min(speed, math.sqrt(0.6 * accelerate * distance), NEAR_GAIN * distance)


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
