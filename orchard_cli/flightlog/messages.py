"""The JSON messages of the log: one struct is the schema, the encoder and the decoder of a topic.

Every message carries the flight clock's time in seconds; positions are metres in the site frame,
rates rad/s in the body frame, quaternions (w, x, y, z). A value that is unknown is absent, never
null and never 0: Foxglove's JSON schema reader knows neither null nor references.
"""

from __future__ import annotations

import math
from typing import Annotated, Any

import msgspec
import numpy as np
from msgspec import UNSET, Meta, Struct, UnsetType
from numpy.typing import ArrayLike

Triple = Annotated[list[float], Meta(min_length=3, max_length=3)]
Quadruple = Annotated[list[float], Meta(min_length=4, max_length=4)]


class Odometry(Struct, frozen=True, kw_only=True):
    """The vehicle's estimate of itself, as heard from the autopilot: /odometry."""

    time: float
    position_m: Triple
    velocity_m_s: Triple
    site_from_body: Quadruple
    angular_velocity_rad_s: Triple | UnsetType = UNSET
    armed: bool
    mode: str
    landed: str
    ready: bool
    not_ready: list[str]
    heard: float


class Battery(Struct, frozen=True, kw_only=True):
    """What is left: /battery. The share goes from 1 (full) to 0."""

    time: float
    share: float | UnsetType = UNSET
    voltage_v: float | UnsetType = UNSET


class Setpoint(Struct, frozen=True, kw_only=True):
    """One offboard command: /setpoint."""

    time: float
    position_m: Triple
    velocity_m_s: Triple | UnsetType = UNSET
    acceleration_m_s2: Triple | UnsetType = UNSET
    yaw_rad: float
    yaw_rate_rad_s: float


class Stage(Struct, frozen=True, kw_only=True):
    """How long one stage of the onboard cycle took."""

    name: str
    ms: float


class Planner(Struct, frozen=True, kw_only=True):
    """One onboard cycle: /planner. `blocked_at_m` is absent when the path ahead is free."""

    time: float
    frame_time: float
    decision: str
    why: str
    blocked_at_m: float | UnsetType = UNSET
    stages: list[Stage]


class Safety(Struct, frozen=True, kw_only=True):
    """The flight's state, what safety does and the faults seen: /safety."""

    time: float
    phase: str
    action: str
    why: str
    faults: list[str]
    tracking_m: float | UnsetType = UNSET


class Spray(Struct, frozen=True, kw_only=True):
    """The pump and the tank: /spray. The level goes from 1 (full) to 0."""

    time: float
    on: bool
    row: int | UnsetType = UNSET
    why: str
    level: float | UnsetType = UNSET
    used_l: float | UnsetType = UNSET


class Truth(Struct, frozen=True, kw_only=True):
    """Where the simulated vehicle really was: /truth. Never on a real flight.

    `contact` names what it has touched, from then on; empty: nothing; absent: nobody looked.
    """

    time: float
    position_m: Triple
    velocity_m_s: Triple
    site_from_body: Quadruple
    contact: str | UnsetType = UNSET


class Reflection(Struct, frozen=True, kw_only=True):
    """One of a radar scan; angles are + to the left and up, the speed + away."""

    range_m: float
    azimuth_rad: float
    elevation_rad: float
    speed_m_s: float | UnsetType = UNSET


class RadarSweep(Struct, frozen=True, kw_only=True):
    """What the radar saw, and how it sits on the body: /sensors/radar."""

    time: float
    returns: list[Reflection]
    range_max_m: float
    width_rad: float
    height_rad: float
    rate_hz: float
    position_body_m: Triple
    body_from_radar: Annotated[list[float], Meta(min_length=9, max_length=9)]  # row by row


class Beam(Struct, frozen=True, kw_only=True):
    """One laser rangefinder; `range_m` is absent when nothing is within its reach."""

    name: str
    range_m: float | UnsetType = UNSET
    place_body_m: Triple
    direction_body: Triple


class Ranges(Struct, frozen=True, kw_only=True):
    """What the laser rangefinders measured: /sensors/range."""

    time: float
    beams: list[Beam]
    range_max_m: float
    rate_hz: float


class Curve(Struct, frozen=True, kw_only=True):
    """A trajectory taken into flight, exactly: /trajectory/curve.

    A uniform cubic B-spline in time: `control_points_m` holds x, y, z of each point in turn.
    """

    time: float
    start: float
    interval: float
    control_points_m: list[float]
    why: str


JSON_TOPICS: dict[str, type[Struct]] = {
    "/odometry": Odometry,
    "/battery": Battery,
    "/setpoint": Setpoint,
    "/planner": Planner,
    "/safety": Safety,
    "/spray": Spray,
    "/truth": Truth,
    "/sensors/radar": RadarSweep,
    "/sensors/range": Ranges,
    "/trajectory/curve": Curve,
}


def schema(message: type[Struct]) -> dict[str, Any]:
    """JSON Schema of a message without references, as Foxglove wants it."""
    _, components = msgspec.json.schema_components([message])
    found: dict[str, Any] = _inlined(components[message.__name__], components)
    return {**found, "title": f"orchard.{message.__name__}"}


def _inlined(node: Any, components: dict[str, Any]) -> Any:
    if isinstance(node, list):
        return [_inlined(item, components) for item in node]
    if not isinstance(node, dict):
        return node
    if "$ref" in node:
        return _inlined(components[node["$ref"].rsplit("/", 1)[1]], components)
    return {key: _inlined(value, components) for key, value in node.items()}


def known(value: float | None) -> float | UnsetType:
    """The number, or absent when it is None, NaN or infinite."""
    return float(value) if value is not None and np.isfinite(value) else UNSET


def known_vector(values: ArrayLike) -> list[float] | UnsetType:
    """The vector, or absent when any of it is NaN or infinite."""
    found: list[float] = np.asarray(values, dtype=np.float64).tolist()
    return found if all(map(math.isfinite, found)) else UNSET


def vector(values: ArrayLike) -> list[float]:
    """The vector as a list; ValueError when it is not finite throughout."""
    found: list[float] = np.asarray(values, dtype=np.float64).tolist()
    if not all(map(math.isfinite, found)):
        raise ValueError("a position, velocity or attitude is not finite")
    return found
