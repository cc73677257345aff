"""The autopilot's estimate of a tick, unpacked once."""

from __future__ import annotations

import math
from dataclasses import dataclass

from orchard_cli.model.arrays import Array, Vector


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
    turning: float  # rad/s, the greatest of the rates
    speed: float  # m/s, horizontal
    climb: float  # m/s, upwards

    @classmethod
    def of(cls, time: float, flat: Array) -> Seen:
        """From the flat array (16,) of _kernels.look, which becomes read-only."""
        flat.setflags(write=False)
        x, y, climb = flat[3:6].tolist()
        yaw, height, turning = flat[13:].tolist()
        return cls(
            time, flat[0:3], flat[3:6], flat[6:10], flat[10:13],
            yaw, height, turning, math.hypot(x, y), climb,
        )  # fmt: skip
