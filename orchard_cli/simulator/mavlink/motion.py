"""Messages about motion, field by field as PX4 fills them (px4/message_samples.txt)."""

from __future__ import annotations

import math
from typing import Any

from pymavlink.dialects.v20 import development as mav

from orchard_cli.simulator.autopilot import Mode
from orchard_cli.simulator.body._kernels import GRAVITY

from .earth import Triple
from .scope import Scope, e7, mm

NAN = math.nan


def gps_raw_int(s: Scope) -> Any:
    """24."""
    t, fix = s.told, s.autopilot.inputs.gps_fix
    course = math.degrees(math.atan2(t.velocity[1], t.velocity[0])) % 360
    return mav.MAVLink_gps_raw_int_message(
        0, 6 if fix else 0, e7(t.latitude), e7(t.longitude), mm(t.altitude), 70, 110,
        round(t.ground_speed * 100), round(course * 100) % 36000, 10 if fix else 0, mm(t.altitude),
        14, 20, 50, 0, 0,
    )  # fmt: skip


def attitude(s: Scope) -> Any:
    """30."""
    return mav.MAVLink_attitude_message(s.told.boot_ms, *s.told.roll_pitch_yaw, *s.told.rates)


def attitude_quaternion(s: Scope) -> Any:
    """31."""
    return mav.MAVLink_attitude_quaternion_message(
        s.told.boot_ms, *s.told.q, *s.told.rates, (0.0, 0.0, 0.0, 0.0)
    )


def local_position(s: Scope) -> Any:
    """32."""
    return mav.MAVLink_local_position_ned_message(s.told.boot_ms, *s.told.ned, *s.told.velocity)


def global_position(s: Scope) -> Any | None:
    """33; none without a global position."""
    if not s.autopilot.global_position_ok:
        return None
    t = s.told
    return mav.MAVLink_global_position_int_message(
        t.boot_ms, e7(t.latitude), e7(t.longitude), mm(t.altitude), mm(t.above_home),
        *(round(v * 100) for v in t.velocity), t.heading_cdeg,
    )  # fmt: skip


def vfr_hud(s: Scope) -> Any:
    """74."""
    t = s.told
    return mav.MAVLink_vfr_hud_message(
        NAN, t.ground_speed, t.heading_cdeg // 100, round(100 * s.autopilot.craft.collective),
        t.altitude, -t.velocity[2],
    )  # fmt: skip


def attitude_target(s: Scope) -> Any:
    """83."""
    a = s.autopilot
    q = s.earth.attitude(a.craft.attitude_wanted)
    return mav.MAVLink_attitude_target_message(
        s.told.boot_ms, 0, q, 0.0, 0.0, 0.0, a.craft.collective
    )


def position_target(s: Scope) -> Any:
    """85: what the controller is asked for."""
    d, earth = s.autopilot.demand, s.earth
    return mav.MAVLink_position_target_local_ned_message(
        s.told.boot_ms, 1, 0, *earth.local(d.position_site), *earth.turned(d.velocity_site),
        *earth.turned(d.acceleration_site), earth.yaw_site(d.yaw_site), -d.yaw_rate,
    )  # fmt: skip


def position_target_global(s: Scope) -> Any | None:
    """87: where the automatic modes head for."""
    a = s.autopilot
    if a.mode is Mode.OFFBOARD or not a.armed:
        return None
    n, e, d = s.earth.local(a.target_site)
    latitude, longitude = s.earth.degrees(n, e)
    return mav.MAVLink_position_target_global_int_message(
        s.told.boot_ms, 5, 0, e7(latitude), e7(longitude), s.earth.height - d,
        NAN, NAN, NAN, 0.0, 0.0, 0.0, NAN, 0.0,
    )  # fmt: skip


def highres_imu(s: Scope) -> Any:
    """105: specific force and rates in FRD; the fields that are not simulated hold still."""
    force = s.autopilot.craft.acceleration_site.copy()
    force[2] += GRAVITY
    x, y, z = turn_back(s.told.q, s.earth.turned(force))
    return mav.MAVLink_highres_imu_message(
        s.told.boot_us, x, y, z, *s.told.rates, 0.23, 0.03, 0.43, 983.55, 0.0, s.told.altitude,
        15.0, 63, 0,
    )  # fmt: skip


def scaled_imu(s: Scope) -> Any:
    """26."""
    force = s.autopilot.craft.acceleration_site.copy()
    force[2] += GRAVITY
    milli_g = [round(v / GRAVITY * 1000) for v in turn_back(s.told.q, s.earth.turned(force))]
    milli_rad = [round(v * 1000) for v in s.told.rates]
    return mav.MAVLink_scaled_imu_message(s.told.boot_ms, *milli_g, *milli_rad, 219, 0, 413, 1500)


def turn_back(q: tuple[float, float, float, float], v: Triple) -> Triple:
    """A NED vector in body FRD."""
    w, x, y, z = q
    a, b, c = v
    return (
        (1 - 2 * (y * y + z * z)) * a + 2 * (x * y + w * z) * b + 2 * (x * z - w * y) * c,
        2 * (x * y - w * z) * a + (1 - 2 * (x * x + z * z)) * b + 2 * (y * z + w * x) * c,
        2 * (x * z + w * y) * a + 2 * (y * z - w * x) * b + (1 - 2 * (x * x + y * y)) * c,
    )


def hil_state(s: Scope) -> Any:
    """115: the truth."""
    a = s.autopilot
    n, e, d = s.earth.local(a.craft.body.position_site)
    latitude, longitude = s.earth.degrees(n, e)
    v = [round(value * 100) for value in s.earth.turned(a.craft.body.velocity_site)]
    p, q, r = a.craft.body.rates_body.tolist()
    return mav.MAVLink_hil_state_quaternion_message(
        s.told.boot_us, s.earth.attitude(a.craft.body.site_from_body), p, -q, -r, e7(latitude),
        e7(longitude), mm(s.earth.height - d), *v, 0, 0, 0, 0, 0,
    )  # fmt: skip


def distance_sensor(s: Scope) -> Any:
    """132: height above the ground, 0 to 100 m."""
    return mav.MAVLink_distance_sensor_message(
        s.told.boot_ms, 0, 10000, min(round(s.told.height * 100), 10000), 0, 0, 25, 0,
        quaternion=(0.0, 0.0, 0.0, 0.0),
    )  # fmt: skip


def altitude(s: Scope) -> Any:
    """141."""
    t = s.told
    local = -t.ned[2]
    return mav.MAVLink_altitude_message(
        t.boot_us, t.altitude, t.altitude, local, t.above_home, local - t.height, t.height
    )


def estimator_status(s: Scope) -> Any:
    """230."""
    return mav.MAVLink_estimator_status_message(
        s.told.boot_us, 959, 0.1, 0.06, 0.01, 0.05, 0.01, NAN, 0.1, 0.05
    )


def odometry(s: Scope) -> Any:
    """331; as PX4, velocity is in NED."""
    t = s.told
    return mav.MAVLink_odometry_message(
        t.boot_us, 1, 1, *t.ned, t.q, *t.velocity, *t.rates, _POSE_COVARIANCE, _SPEED_COVARIANCE,
        0, 8, 0,
    )  # fmt: skip


def _upper_triangle(diagonal: tuple[float, ...]) -> list[float]:
    """(21,) row-major upper triangle of a diagonal (6, 6) matrix."""
    return [diagonal[row] if row == column else 0.0 for row in range(6) for column in range(row, 6)]


_POSE_COVARIANCE = _upper_triangle((1e-2, 1e-2, 2.5e-3, 1e-5, 1e-5, 1e-5))
_SPEED_COVARIANCE = _upper_triangle((1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0))
