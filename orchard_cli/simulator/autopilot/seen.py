"""The autopilot's estimate of a tick, unpacked once."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array, Vector
from orchard_cli.simulator.control.believe import believe


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What the autopilot believes at a time; never the truth."""

    time: float  # s since boot
    position_site: Vector  # (3,) m
    velocity_site: Vector  # (3,) m/s
    site_from_body: Vector  # (4,)
    rates_body: Vector  # (3,) rad/s
    yaw_site: float  # rad
    height: float  # m above the ground, by the distance sensor

    @property
    def speed(self) -> float:
        """Horizontal, m/s."""
        return math.hypot(self.velocity_site[0], self.velocity_site[1])


def see(time: float, state: Array, error: Array, ground_height: float) -> Seen:
    """The estimate from the body's state (17,) and the estimator's error (9,)."""
    position, velocity, attitude = believe(state, error)
    w, x, y, z = attitude.tolist()
    return Seen(
        time,
        position,
        velocity,
        attitude,
        np.array(state[10:13]),
        math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
        max(0.0, float(state[2]) - ground_height),
    )
