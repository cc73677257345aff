"""Messages about health, modes and time, field by field as PX4 fills them."""

from __future__ import annotations

from typing import Any

from pymavlink.dialects.v20 import development as mav

from orchard_cli.model.vehicle import Landed
from orchard_cli.simulator.autopilot import Mode

from .scope import Scope, e7, mm

SENSORS = 0x0200402F  # present on PX4's SITL; armed adds rate control
SENSORS_ARMED = 0x01000000
HEALTHY = 0x0320881F  # without what GPS and the arming checks add
HEALTHY_GPS = 0x00004020  # position control and GPS
HEALTHY_ARMING = 0x10000000
CAPABILITIES = 59647
VERSION = 0x011100C0  # 1.17.0, release
_LANDED = {Landed.ON_GROUND: 1, Landed.IN_AIR: 2, Landed.TAKING_OFF: 3, Landed.LANDING: 4}


def heartbeat(s: Scope) -> Any:
    """0: mode and arming."""
    a = s.autopilot
    base = 1 | 16 | (128 if a.armed else 0)
    if a.mode is Mode.POSCTL:
        base |= 64
    elif a.mode is not Mode.OFFBOARD:
        base |= 8 | 4
    flying = 4 if a.mode is a.intention else 5  # active, or critical under a failsafe
    resting = 0 if a.not_ready() else 3
    return mav.MAVLink_heartbeat_message(
        2, 12, base, a.mode.custom, flying if a.armed else resting, 3
    )


def sys_status(s: Scope) -> Any:
    """1: health and battery."""
    a = s.autopilot
    present = SENSORS | (SENSORS_ARMED if a.armed else 0)
    health = HEALTHY | (HEALTHY_GPS if a.global_position_ok else 0)
    if not a.not_ready():
        health |= HEALTHY_ARMING
    battery = a.craft.battery
    return mav.MAVLink_sys_status_message(
        present, present | 0x10000, health, 120, round(a.craft.battery_voltage * 1000),
        round(battery.current * 100), round(battery.share * 100), 0, 0, 0, 0, 0, 0, 0, 0, 1,
    )  # fmt: skip


def system_time(s: Scope) -> Any:
    """2."""
    return mav.MAVLink_system_time_message(
        round((s.utc + s.told.boot_us * 1e-6) * 1e6), s.told.boot_ms
    )


def servo_output(s: Scope) -> Any:
    """36."""
    return mav.MAVLink_servo_output_raw_message(
        s.told.boot_us % 2**32, 0, *pulses(s), *([900] * 4), *([900] * 8)
    )


def pulses(s: Scope) -> list[int]:
    """Rotor speeds as pulse widths."""
    a = s.autopilot
    if not a.armed:
        return [900] * 4
    top = a.craft.body.airframe.speed_max
    return [round(1000 + 1000 * speed / top) for speed in a.craft.body.state[13:17].tolist()]


def mission_current(s: Scope) -> Any:
    """42."""
    a = s.autopilot
    count = len(a.mission)
    if not count:
        state = 1
    elif a.mission_complete:
        state = 5
    elif a.mode is Mode.MISSION:
        state = 3
    else:
        state = 4 if a.mission_index else 2
    index = min(a.mission_index, max(count - 1, 0))
    mode = 1 if a.mode in (Mode.MISSION, Mode.TAKEOFF, Mode.LAND, Mode.RETURN) else 2
    return mav.MAVLink_mission_current_message(index, count or 65535, state, mode)


def timesync(s: Scope) -> Any:
    """111: a question, which the client answers."""
    return mav.MAVLink_timesync_message(0, s.told.boot_us * 1000)


def battery_status(s: Scope) -> Any:
    """147."""
    a = s.autopilot
    battery = a.craft.battery
    cells = [round(a.craft.battery_voltage * 1000)] + [65535] * 9
    return mav.MAVLink_battery_status_message(
        0, 1, 1, 32767, cells, round(battery.current * 100), round(battery.used_mah), -1,
        round(battery.share * 100), 0, 1,
    )  # fmt: skip


def autopilot_version(_: Scope) -> Any:
    """148."""
    zeros = [0] * 8
    return mav.MAVLink_autopilot_version_message(
        CAPABILITIES, VERSION, VERSION, 0, 1, zeros, zeros, zeros, 0, 0, 0x4F5243484152440
    )


def vibration(s: Scope) -> Any:
    """241."""
    return mav.MAVLink_vibration_message(s.told.boot_us, 0.0, 0.0, 0.0, 0, 0, 0)


def home_position(s: Scope) -> Any | None:
    """242; none until there is a global position."""
    a = s.autopilot
    if not a.global_position_ok:
        return None
    n, e, d = s.earth.local(a.home_site)
    latitude, longitude = s.earth.degrees(n, e)
    return mav.MAVLink_home_position_message(
        e7(latitude), e7(longitude), mm(s.earth.height - d), n, e, d, (1.0, 0.0, 0.0, 0.0),
        0.0, 0.0, 0.0, s.told.boot_us,
    )  # fmt: skip


def extended_state(s: Scope) -> Any:
    """245."""
    return mav.MAVLink_extended_sys_state_message(0, _LANDED[s.autopilot.landed])


def actuator_output(s: Scope) -> Any:
    """375."""
    return mav.MAVLink_actuator_output_status_message(
        s.told.boot_us, 16, [*map(float, pulses(s)), *([900.0] * 12), *([0.0] * 16)]
    )


def current_mode(s: Scope) -> Any:
    """436."""
    a = s.autopilot
    return mav.MAVLink_current_mode_message(a.mode.standard, a.mode.custom, a.intention.custom)


def global_origin(s: Scope) -> Any | None:
    """49; none until there is a global position."""
    if not s.autopilot.global_position_ok:
        return None
    earth = s.earth
    return mav.MAVLink_gps_global_origin_message(
        e7(earth.latitude), e7(earth.longitude), mm(earth.height), s.told.boot_us
    )


def scaled_pressure(s: Scope) -> Any:
    """29: the standard atmosphere near the ground."""
    return mav.MAVLink_scaled_pressure_message(
        s.told.boot_ms, 1013.25 - 0.12 * s.told.altitude, 0.0, 1338
    )


def rc_channels(_: Scope) -> None:
    """65: there is no receiver, so nothing is sent, however often it is asked for."""


def ping(s: Scope) -> Any:
    """4: a question, which the client answers."""
    return mav.MAVLink_ping_message(s.told.boot_us, int(s.told.boot_us // 1_000_000), 0, 0)
