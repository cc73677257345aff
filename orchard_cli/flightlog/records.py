"""Messages back into nouns: the inverse of scribe.py."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from msgspec import UNSET, UnsetType

from orchard_cli.flightlog import messages
from orchard_cli.model.arrays import Array
from orchard_cli.model.flown import Commands, Contact, Track
from orchard_cli.model.records import (
    LogLine,
    NewTrajectory,
    OccupiedCells,
    PlannerRecord,
    SafetyRecord,
    Severity,
    SprayRecord,
)
from orchard_cli.model.sensors import Beams, Radar, RadarScan, RangeScan
from orchard_cli.model.trajectory import Trajectory

POSSIBLE = 1e9
"""No time (s since the computer started), place (m) or speed (m/s) of a flight is larger."""

_NO_VECTOR = [float("nan")] * 3


def number(value: float | UnsetType) -> float:
    """NaN when absent."""
    return float("nan") if value is UNSET else float(value)


def _triple(value: list[float] | UnsetType) -> list[float]:
    return _NO_VECTOR if isinstance(value, UnsetType) else value


def _advancing(times: Array) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Which samples are newer than all before them."""
    newest = np.maximum.accumulate(np.concatenate([[-np.inf], times]))[:-1]
    return times > newest


class Rows:
    """Numbers of the messages that come in thousands, kept as numbers and not as objects."""

    def __init__(self, row: Callable[[Any], tuple[float, ...]], width: int) -> None:
        self._row, self._width = row, width
        self._numbers = array("d")

    def add(self, message: Any) -> None:
        """Keep one decoded message."""
        self._numbers.extend(self._row(message))

    def table(self) -> tuple[Array, int]:
        """(n, width) in time order, each time once, the time first; and how many went back."""
        table = np.frombuffer(self._numbers, dtype=np.float64).reshape(-1, self._width)
        table = table[~(np.abs(table) > POSSIBLE).any(axis=1)]  # NaN, not known, is possible
        times = table[:, 0]
        return table[_advancing(times)], int((np.diff(times) < 0).sum())

    @property
    def impossible(self) -> int:
        """Messages with numbers that no flight has; they are left out."""
        table = np.frombuffer(self._numbers, dtype=np.float64).reshape(-1, self._width)
        return int((np.abs(table) > POSSIBLE).any(axis=1).sum())


def motion_rows() -> Rows:
    """Of /odometry and /truth: time, position, velocity, attitude, angular velocity."""
    return Rows(
        lambda one: (
            one.time,
            *one.position_m,
            *one.velocity_m_s,
            *one.site_from_body,
            *_triple(getattr(one, "angular_velocity_rad_s", UNSET)),
        ),
        14,
    )


def setpoint_rows() -> Rows:
    """Of /setpoint: time, position, velocity, acceleration, yaw."""
    return Rows(
        lambda one: (
            one.time,
            *one.position_m,
            *_triple(one.velocity_m_s),
            *_triple(one.acceleration_m_s2),
            one.yaw_rad,
        ),
        11,
    )


def track(rows: Rows) -> tuple[Track, int]:
    """The samples in time order, each once; and how many went back in time."""
    table, backwards = rows.table()
    parts = table[:, 0], table[:, 1:4], table[:, 4:7], table[:, 7:11], table[:, 11:14]
    return Track(*parts), backwards


def contacts(found: Sequence[messages.Truth]) -> tuple[Contact, ...] | None:
    """What was touched first, if anything; None when no simulator looked for it."""
    looked = [(one.time, one.contact) for one in found if one.contact is not UNSET]
    if not looked:
        return None
    return tuple(Contact(time, name) for time, name in looked if name)[:1]


def commands(rows: Rows) -> Commands:
    """The setpoints in time order, each once."""
    table, _ = rows.table()
    return Commands(table[:, 0], table[:, 1:4], table[:, 4:7], table[:, 7:10], table[:, 10])


def planner(one: messages.Planner) -> PlannerRecord:
    """One onboard cycle."""
    return PlannerRecord(
        time=one.time,
        frame_time=one.frame_time,
        decision=one.decision,
        why=one.why,
        blocked_at=None if isinstance(one.blocked_at_m, UnsetType) else one.blocked_at_m,
        stages_ms={stage.name: stage.ms for stage in one.stages},
    )


def safety(one: messages.Safety) -> SafetyRecord:
    """A state of the flight."""
    tracking = None if isinstance(one.tracking_m, UnsetType) else one.tracking_m
    return SafetyRecord(one.time, one.phase, one.action, one.why, tuple(one.faults), tracking)


def spray(one: messages.Spray) -> SprayRecord:
    """The pump."""
    row = None if isinstance(one.row, UnsetType) else one.row
    level = None if isinstance(one.level, UnsetType) else one.level
    used = None if isinstance(one.used_l, UnsetType) else one.used_l
    return SprayRecord(one.time, one.on, row, one.why, level, used)


def radar(one: messages.RadarSweep) -> RadarScan:
    """A radar scan."""
    rows = [(r.range_m, r.azimuth_rad, r.elevation_rad, number(r.speed_m_s)) for r in one.returns]
    mount = Radar(
        one.range_max_m, one.width_rad, one.height_rad, one.rate_hz,
        np.array(one.body_from_radar).reshape(3, 3), np.array(one.position_body_m),
    )  # fmt: skip
    return RadarScan(one.time, np.array(rows), mount)


def ranges(one: messages.Ranges) -> RangeScan:
    """A scan of the laser rangefinders."""
    far = [float("inf") if beam.range_m is UNSET else beam.range_m for beam in one.beams]
    beams = Beams(
        tuple(beam.name for beam in one.beams),
        np.array([beam.place_body_m for beam in one.beams]).reshape(-1, 3),
        np.array([beam.direction_body for beam in one.beams]).reshape(-1, 3),
        one.range_max_m,
        one.rate_hz,
    )
    return RangeScan(one.time, np.array(far), beams)


def new_trajectory(one: messages.Curve) -> NewTrajectory:
    """A trajectory, without its guide path."""
    control = np.array(one.control_points_m).reshape(-1, 3)
    curve = Trajectory(one.start, one.interval, control)
    return NewTrajectory(one.time, curve, np.empty((0, 3)), one.why)


def line(one: Any, log_time: int, utc_offset_ns: int) -> LogLine:
    """A foxglove.Log message."""
    severity = Severity(one.level) if one.level in (1, 2, 3, 4) else Severity.ERROR
    return LogLine((log_time - utc_offset_ns) / 1e9, severity, one.message, one.name)


def cells(one: Any, log_time: int, utc_offset_ns: int) -> OccupiedCells:
    """A foxglove.PointCloud of ours: x, y, z and the cell's edge."""
    table = np.frombuffer(one.data, dtype="<f4").reshape(-1, 4).astype(np.float64)
    cell = float(table[0, 3]) if len(table) else 0.0
    return OccupiedCells((log_time - utc_offset_ns) / 1e9, table[:, :3], cell)
