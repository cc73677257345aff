"""Which messages are streamed, and when each is due."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from . import motion, status
from .scope import Scope

Builder = Callable[[Scope], Any]

BUILDERS: dict[int, tuple[Builder, float]] = {
    0: (status.heartbeat, 1.0),
    1: (status.sys_status, 5.0),
    2: (status.system_time, 1.0),
    4: (status.ping, 1.0),
    24: (motion.gps_raw_int, 8.0),
    26: (motion.scaled_imu, 0.0),
    29: (status.scaled_pressure, 1.0),
    30: (motion.attitude, 100.0),
    31: (motion.attitude_quaternion, 50.0),
    32: (motion.local_position, 30.0),
    33: (motion.global_position, 50.0),
    36: (status.servo_output, 10.0),
    42: (status.mission_current, 1.0),
    49: (status.global_origin, 0.0),
    65: (status.rc_channels, 0.0),
    74: (motion.vfr_hud, 10.0),
    83: (motion.attitude_target, 10.0),
    85: (motion.position_target, 10.0),
    87: (motion.position_target_global, 10.0),
    105: (motion.highres_imu, 50.0),
    111: (status.timesync, 10.0),
    115: (motion.hil_state, 0.0),
    132: (motion.distance_sensor, 10.0),
    141: (motion.altitude, 10.0),
    147: (status.battery_status, 0.5),
    148: (status.autopilot_version, 0.0),
    230: (motion.estimator_status, 1.0),
    241: (status.vibration, 0.5),
    242: (status.home_position, 0.5),
    245: (status.extended_state, 5.0),
    331: (motion.odometry, 30.0),
    375: (status.actuator_output, 0.0),
    436: (status.current_mode, 0.5),
}
"""Message id → how it is made, and its rate on PX4's onboard link in Hz (px4/message_rates);
0: only when asked for. PX4 also sends 8, 380, 410 and 411, which pymavlink does not know, and
OpenDroneID (12901, 12904)."""

FASTEST = {0: 1.0, 24: 8.0}
"""Hz that a client cannot raise: PX4's heartbeat is fixed, and its GPS gives no more."""


class Streams:
    """The streams of one link, each with its own interval."""

    def __init__(self) -> None:
        self._interval = {number: 1 / rate for number, (_, rate) in BUILDERS.items() if rate > 0}
        self._due = dict.fromkeys(self._interval, 0.0)

    def interval_us(self, number: int) -> int:
        """The present interval; -1 when the message is not streamed."""
        return round(self._interval[number] * 1e6) if number in self._interval else -1

    def set_interval(self, number: int, interval_us: float, now: float) -> bool:
        """Stream a message at an interval: 0 its default, -1 never. False: no such message."""
        if number not in BUILDERS:
            return False
        if interval_us == 0:
            rate = BUILDERS[number][1]
            interval_us = 1e6 / rate if rate > 0 else -1
        self._due.pop(number, None)
        self._interval.pop(number, None)
        if interval_us > 0:
            interval = max(interval_us * 1e-6, 1 / FASTEST.get(number, 1e9))
            self._interval[number], self._due[number] = interval, now + interval
        return True

    def due(self, now: float) -> list[int]:
        """Messages to send now, and each one's next turn. A late one is not made up for."""
        ready = [number for number, due in self._due.items() if due <= now + 1e-6]
        for number in ready:
            interval = self._interval[number]
            due = self._due[number] + interval
            self._due[number] = due if due > now else now + interval
        return ready
