"""What an autopilot says of itself on the ground, for `orchard doctor`. Nothing is changed."""

from __future__ import annotations

import contextlib
import math
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mavsdk
from mavsdk.plugins.info import Info
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import Telemetry

from .failsafes import rules
from .link import first_autopilot
from .port_lock import PortLock
from .telemetry import health_problems

LISTENING = 3.0  # s of telemetry that rates are counted over


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter that rules when this program is gone."""

    name: str
    value: float | None  # None: the autopilot has no such one
    wanted: float
    safe: bool
    why: str


@dataclass(frozen=True, slots=True)
class LinkReport:
    """An autopilot as it stands."""

    firmware: str
    armed: bool
    problems: tuple[str, ...]  # of its health, in words; empty when it may arm
    fix: str  # of GPS, with the number of satellites
    battery_share: float | None
    rates: dict[str, float]  # Hz, of the streams that a flight needs, as they come now
    parameters: tuple[Parameter, ...]


def inspect_link(url: str, flight_height: float, patience: float = 10.0) -> LinkReport:
    """Listen to the autopilot on a MAVSDK URL and read its parameters; blocks some seconds.

    `flight_height` (m above ground) is what a return may climb to. Raises LinkError when nothing
    answers within `patience` s, or another orchard has the port.
    """
    lock = PortLock(url)
    mavsdk.log_subscribe(lambda *_: True)
    hub = mavsdk.Mavsdk(
        mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.COMPANION_COMPUTER)
    )
    try:
        system = first_autopilot(hub, url, patience)
        telemetry = Telemetry(system)
        rates = _rates(telemetry)
        gps, battery = telemetry.gps_info(), telemetry.battery().remaining_percent
        return LinkReport(
            firmware=_firmware(Info(system)),
            armed=bool(telemetry.armed()),
            problems=health_problems(telemetry.health()),
            fix=f"{gps.fix_type.name.lower().replace('_', ' ')}, {gps.num_satellites} satellites",
            battery_share=None if math.isnan(battery) else battery / 100,
            rates=rates,
            parameters=_parameters(Param(system), flight_height),
        )
    finally:
        hub.destroy()
        lock.release()


def _rates(telemetry: Telemetry) -> dict[str, float]:
    heard: Counter[str] = Counter()

    def count(name: str) -> Callable[..., None]:
        return lambda *_: heard.update((name,))

    telemetry.subscribe_odometry(count("odometry"))
    telemetry.subscribe_position_velocity_ned(count("position and velocity"))
    telemetry.subscribe_attitude_quaternion(count("attitude"))
    began = time.monotonic()
    time.sleep(LISTENING)
    passed = time.monotonic() - began
    names = ("odometry", "position and velocity", "attitude")
    return {name: heard[name] / passed for name in names}


def _firmware(info: Info) -> str:
    for _ in range(10):
        with contextlib.suppress(mavsdk.MavsdkError):
            v: Any = info.get_version()
            number = f"{v.flight_sw_major}.{v.flight_sw_minor}.{v.flight_sw_patch}"
            return f"{number} ({v.flight_sw_version_type.name.lower()})"
        time.sleep(0.2)
    return "not told"


def _parameters(param: Param, flight_height: float) -> tuple[Parameter, ...]:
    found = []
    for rule in rules(flight_height):
        read = param.get_param_float if rule.is_float else param.get_param_int
        try:
            value: float | None = float(read(rule.name))
        except mavsdk.MavsdkError:
            value = None
        safe = value is not None and rule.safe(value)
        found.append(Parameter(rule.name, value, rule.wanted, safe, rule.why))
    return tuple(found)
