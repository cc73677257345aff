"""What the vehicle tells and what it is told, in the site frame.

Body frame: x forward, y left, z up. Quaternions are (w, x, y, z), unit, rotating body vectors
into the site frame.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import Enum
from itertools import takewhile

import numpy as np

from .arrays import Vector


class FlightMode(Enum):
    """The autopilot's mode, as far as the flight decides by it."""

    UNKNOWN = "unknown"
    HOLD = "hold"
    TAKEOFF = "takeoff"
    OFFBOARD = "offboard"
    MISSION = "mission"
    RETURN = "return"
    LAND = "land"
    PILOT = "pilot"  # any mode in which sticks move the vehicle


class Landed(Enum):
    """The autopilot's own idea of the ground."""

    UNKNOWN = "unknown"
    ON_GROUND = "on_ground"
    TAKING_OFF = "taking_off"
    IN_AIR = "in_air"
    LANDING = "landing"


class Command(Enum):
    """What a vehicle can be asked. That it was done is seen in the telemetry, never assumed."""

    ARM = "arm"
    DISARM = "disarm"
    TAKEOFF = "takeoff"
    OFFBOARD = "offboard"
    HOLD = "hold"
    RETURN = "return"
    LAND = "land"


@dataclass(frozen=True, slots=True)
class Answer:
    """What the autopilot answered to a command. Accepted is not done."""

    command: Command
    accepted: bool
    said: str  # the autopilot's own words
    time: float  # s, flight clock


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """Where the body was at a time."""

    time: float  # s, flight clock
    position_site: Vector  # (3,) m
    site_from_body: Vector  # (4,) quaternion w, x, y, z


def poses_after(poses: deque[Pose], time: float) -> tuple[Pose, ...]:
    """Those later than `time`, s, of poses in their order; only these are looked at."""
    newer = tuple(takewhile(lambda pose: pose.time > time, reversed(poses)))
    return newer[::-1]


@dataclass(frozen=True, slots=True, eq=False)
class VehicleState:
    """The newest telemetry, each group with the age that it has."""

    time: float  # s, flight clock: when position, velocity and attitude were measured
    position_site: Vector  # (3,) m
    velocity_site: Vector  # (3,) m/s
    site_from_body: Vector  # (4,) quaternion w, x, y, z
    angular_velocity_body: Vector  # (3,) rad/s
    armed: bool
    mode: FlightMode
    landed: Landed
    heard: float  # s, flight clock: when anything last arrived on the link
    battery_share: float  # 0 to 1; NaN when unknown
    battery_voltage: float  # V; NaN when unknown
    ready: bool  # the autopilot's own health checks pass and it can be armed
    fixed: bool = True  # it knows where on earth it is: a GPS fix, settled
    not_ready: tuple[str, ...] = ()  # its reasons, in words

    @property
    def yaw_site(self) -> float:
        """Angle of the nose from +x, counter-clockwise from above, rad."""
        w, x, y, z = self.site_from_body
        return float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))

    @property
    def pose(self) -> Pose:
        """Position and attitude alone."""
        return Pose(self.time, self.position_site, self.site_from_body)


@dataclass(frozen=True, slots=True, eq=False)
class Setpoint:
    """One offboard command: where to be, how fast, and which way to look."""

    time: float  # s, flight clock: when it was decided
    position_site: Vector  # (3,) m
    velocity_site: Vector  # (3,) m/s
    acceleration_site: Vector  # (3,) m/s²
    yaw_site: float  # rad, counter-clockwise from +x
    yaw_rate: float = 0.0  # rad/s
