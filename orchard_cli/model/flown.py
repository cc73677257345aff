"""A flight as its log tells it: what analysis works on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array, Points, frozen
from .records import (
    LogLine,
    NewTrajectory,
    OccupiedCells,
    PlannerRecord,
    SafetyRecord,
    SprayRecord,
)
from .sensors import RadarScan, RangeScan


def _read_only(values: ArrayLike, width: int | None, count: int, what: str) -> Array:
    """Copy to a read-only float array that may hold NaN; ValueError when the shape is wrong."""
    array = np.array(values, dtype=np.float64)
    shape = (count,) if width is None else (count, width)
    if array.size == 0 and count == 0:
        array = array.reshape(shape)
    if array.shape != shape:
        raise ValueError(f"{what}: shape {array.shape}, expected {shape}")
    array.setflags(write=False)
    return array


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Where the vehicle was, by its own estimate or by the simulator's truth; n >= 0 samples."""

    times: Array  # (n,) s, flight clock, strictly increasing
    positions_site: Points  # (n, 3) m
    velocities_site: Points  # (n, 3) m/s
    site_from_body: Array  # (n, 4) w, x, y, z
    angular_velocities_body: Array  # (n, 3) rad/s; NaN where unknown

    def __post_init__(self) -> None:
        n = len(self.times)
        object.__setattr__(self, "times", frozen(self.times, (None,), "times"))
        if (np.diff(self.times) <= 0).any():
            raise ValueError("times: not increasing")
        for name, width in (
            ("positions_site", 3),
            ("velocities_site", 3),
            ("site_from_body", 4),
            ("angular_velocities_body", 3),
        ):
            object.__setattr__(self, name, _read_only(getattr(self, name), width, n, name))

    def between(self, start: float, end: float) -> Track:
        """The samples with start <= time <= end."""
        inside = (self.times >= start) & (self.times <= end)
        return Track(
            self.times[inside],
            self.positions_site[inside],
            self.velocities_site[inside],
            self.site_from_body[inside],
            self.angular_velocities_body[inside],
        )


@dataclass(frozen=True, slots=True, eq=False)
class Commands:
    """The setpoints that were sent."""

    times: Array  # (n,) s, flight clock, strictly increasing
    positions_site: Points  # (n, 3) m
    velocities_site: Points  # (n, 3) m/s; NaN where not commanded
    accelerations_site: Points  # (n, 3) m/s²; NaN where not commanded
    yaws_site: Array  # (n,) rad

    def __post_init__(self) -> None:
        n = len(self.times)
        object.__setattr__(self, "times", frozen(self.times, (None,), "times"))
        for name, width in (
            ("positions_site", 3),
            ("velocities_site", 3),
            ("accelerations_site", 3),
            ("yaws_site", None),
        ):
            object.__setattr__(self, name, _read_only(getattr(self, name), width, n, name))


@dataclass(frozen=True, slots=True)
class Contact:
    """The simulated vehicle touched something and broke."""

    time: float  # s, flight clock
    name: str  # of what was touched: "pole 2"

    def __str__(self) -> str:
        return f"{self.name} at t = {self.time:.1f} s"


@dataclass(frozen=True, slots=True, eq=False)
class FlownLog:
    """One log, read. Records stand in the order in which they were written."""

    file: str  # name, for messages and tables
    metadata: Mapping[str, str]  # run_id, system, tool_version, vehicle, site, simulated, seed
    attachments: Mapping[str, bytes]  # "mission.json", "world.toml", ...
    odometry: Track
    truth: Track | None  # None: not simulated
    commands: Commands
    battery_times: Array  # (n,) s
    battery_shares: Array  # (n,) 1 is full; NaN where unknown
    planner: tuple[PlannerRecord, ...] = ()
    safety: tuple[SafetyRecord, ...] = ()
    spray: tuple[SprayRecord, ...] = ()
    trajectories: tuple[NewTrajectory, ...] = ()  # without their guide paths
    radar: tuple[RadarScan, ...] = ()
    ranges: tuple[RangeScan, ...] = ()
    maps: tuple[OccupiedCells, ...] = ()
    lines: tuple[LogLine, ...] = ()
    contacts: tuple[Contact, ...] | None = None  # at most one; None: not known
    notes: tuple[str, ...] = field(default=())  # what a reader of figures must know: cut, damaged

    @property
    def system(self) -> str:
        """The avoidance system that flew."""
        return self.metadata.get("system", "unknown")
