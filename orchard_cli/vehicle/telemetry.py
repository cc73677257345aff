"""Newest telemetry from MAVSDK's callbacks, turned into the site frame and the flight clock."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from mavsdk.plugins.telemetry import FlightMode as MavFlightMode
from mavsdk.plugins.telemetry import LandedState, Telemetry

from orchard_cli.model.arrays import Vector
from orchard_cli.model.vehicle import FlightMode, Landed, Pose, VehicleState

from .frames import LocalFrame, flu_from_frd
from .stamps import StampClock

POSE_HISTORY = 2.0  # s

_MODES = {
    MavFlightMode.HOLD: FlightMode.HOLD,
    MavFlightMode.READY: FlightMode.HOLD,
    MavFlightMode.TAKEOFF: FlightMode.TAKEOFF,
    MavFlightMode.OFFBOARD: FlightMode.OFFBOARD,
    MavFlightMode.MISSION: FlightMode.MISSION,
    MavFlightMode.RETURN_TO_LAUNCH: FlightMode.RETURN,
    MavFlightMode.LAND: FlightMode.LAND,
    MavFlightMode.MANUAL: FlightMode.PILOT,
    MavFlightMode.ALTCTL: FlightMode.PILOT,
    MavFlightMode.POSCTL: FlightMode.PILOT,
    MavFlightMode.ACRO: FlightMode.PILOT,
    MavFlightMode.STABILIZED: FlightMode.PILOT,
    MavFlightMode.RATTITUDE: FlightMode.PILOT,
}
_LANDED = {
    LandedState.ON_GROUND: Landed.ON_GROUND,
    LandedState.IN_AIR: Landed.IN_AIR,
    LandedState.TAKING_OFF: Landed.TAKING_OFF,
    LandedState.LANDING: Landed.LANDING,
}
_HEALTH_WORDS = (
    ("is_gyrometer_calibration_ok", "gyroscope not calibrated"),
    ("is_accelerometer_calibration_ok", "accelerometer not calibrated"),
    ("is_magnetometer_calibration_ok", "compass not calibrated"),
    ("is_local_position_ok", "no local position estimate"),
    ("is_global_position_ok", "no global position (GPS fix)"),
    ("is_home_position_ok", "no home position"),
    ("is_armable", "the autopilot's arming checks do not pass"),
)


def health_problems(health: Any) -> tuple[str, ...]:
    """What of MAVSDK's Health is not well, in words; everything when it was never heard."""
    return tuple(words for name, words in _HEALTH_WORDS if not getattr(health, name, False))


@dataclass(frozen=True, slots=True, eq=False)
class _NedPose:
    """A pose as it was told, in local NED and FRD."""

    time: float  # s, flight clock
    position_ned: Vector  # (3,) m
    ned_from_frd: Vector  # (4,) w, x, y, z


class TelemetryFeed:
    """Subscribes on construction and keeps the newest of everything.

    Positions come from ODOMETRY, the one stream that MAVSDK hands on with the autopilot's time
    stamp; its frame fields are lost on the way, so velocity is taken from LOCAL_POSITION_NED.
    Height is measured from the ground that the disarmed vehicle stands on: PX4's local origin is
    up to 0.6 m off it. What is told is turned into the site frame when it is asked for, so that
    the local origin may be found to have moved (`reframe`).
    """

    def __init__(self, telemetry: Telemetry, frame: LocalFrame, now: Callable[[], float]) -> None:
        self._frame = frame
        self._now = now
        self._lock = threading.Lock()
        self._stamps = StampClock()
        self._poses: deque[_NedPose] = deque(maxlen=512)
        self._rates = np.full(3, math.nan)
        self._velocity_ned: Vector | None = None
        self._heard = -math.inf
        self._ground_down: float | None = None
        self._armed: bool | None = None
        self._mode: FlightMode | None = None
        self._landed = Landed.UNKNOWN
        self._battery = (math.nan, math.nan)
        self._health: Any = None
        telemetry.subscribe_odometry(self._on_odometry)
        telemetry.subscribe_position_velocity_ned(self._on_velocity)
        telemetry.subscribe_armed(self._on_armed)
        telemetry.subscribe_flight_mode(self._on_mode)
        telemetry.subscribe_landed_state(self._on_landed)
        telemetry.subscribe_battery(self._on_battery)
        telemetry.subscribe_health(self._on_health)

    def state(self) -> VehicleState | None:
        """Newest state, or None until pose, velocity, mode and arming have been heard."""
        with self._lock:
            if not self._poses or self._velocity_ned is None or self._ground_down is None:
                return None
            if self._mode is None or self._armed is None:
                return None
            pose = self._site_pose(self._poses[-1])
            missing = health_problems(self._health)
            return VehicleState(
                time=pose.time,
                position_site=pose.position_site,
                velocity_site=self._frame.vector_site(self._velocity_ned),
                site_from_body=pose.site_from_body,
                angular_velocity_body=self._rates,
                armed=self._armed,
                mode=self._mode,
                landed=self._landed,
                heard=self._heard,
                battery_share=self._battery[0],
                battery_voltage=self._battery[1],
                ready=not missing,
                fixed=self._health is None or bool(self._health.is_global_position_ok),
                not_ready=missing,
            )

    def poses(self, since: float) -> tuple[Pose, ...]:
        """Poses after `since`, oldest first, at most the last two seconds."""
        with self._lock:
            newest = self._poses[-1].time if self._poses else 0.0
            oldest = max(since, newest - POSE_HISTORY)
            return tuple(self._site_pose(pose) for pose in self._poses if pose.time > oldest)

    def reframe(self, frame: LocalFrame, sunk: float) -> None:
        """The local origin has moved: `frame` is where it is, `sunk` m lower than it was."""
        with self._lock:
            self._frame = frame
            if self._ground_down is not None:
                self._ground_down -= sunk

    def _site_pose(self, pose: _NedPose) -> Pose:
        above = pose.position_ned - np.array([0.0, 0.0, self._ground_down or 0.0])
        return Pose(
            pose.time,
            self._frame.position_site(above),
            self._frame.site_from_body(pose.ned_from_frd),
        )

    def _on_odometry(self, message: Any, _: Any) -> None:
        arrived = self._now()
        p, q, w = message.position_body, message.q, message.angular_velocity_body
        position_ned = np.array([p.x_m, p.y_m, p.z_m])
        if not (np.isfinite(position_ned).all() and math.isfinite(q.w)):
            return
        with self._lock:
            self._heard = arrived
            if self._armed is False:
                self._ground_down = float(position_ned[2])
            if self._ground_down is None:
                return  # armed when first heard: where the ground is cannot be known
            pose = _NedPose(
                self._stamps.flight_time(message.time_usec * 1e-6, arrived),
                position_ned,
                np.array([q.w, q.x, q.y, q.z]),
            )
            if self._poses and pose.time <= self._poses[-1].time - 1.0:
                self._poses.clear()  # rebooted
            self._poses.append(pose)
            self._rates = flu_from_frd(np.array([w.roll_rad_s, w.pitch_rad_s, w.yaw_rad_s]))

    def _on_velocity(self, message: Any, _: Any) -> None:
        v = message.velocity
        velocity_ned = np.array([v.north_m_s, v.east_m_s, v.down_m_s])
        with self._lock:
            self._heard = self._now()
            self._velocity_ned = velocity_ned

    def _on_armed(self, armed: bool, _: Any) -> None:
        with self._lock:
            self._armed = bool(armed)

    def _on_mode(self, mode: Any, _: Any) -> None:
        with self._lock:
            self._mode = _MODES.get(mode, FlightMode.UNKNOWN)

    def _on_landed(self, landed: Any, _: Any) -> None:
        with self._lock:
            self._landed = _LANDED.get(landed, Landed.UNKNOWN)

    def _on_battery(self, battery: Any, _: Any) -> None:
        with self._lock:
            self._battery = (battery.remaining_percent / 100.0, battery.voltage_v)

    def _on_health(self, health: Any, _: Any) -> None:
        with self._lock:
            self._health = health

    @property
    def ground_down(self) -> float:
        """Down coordinate of the ground in the autopilot's local frame, m."""
        with self._lock:
            return self._ground_down or 0.0
