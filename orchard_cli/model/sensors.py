"""Sensors besides the depth camera, and their scans.

Body frame: x forward, y left, z up. The radar's own frame is laid the same way: x along its axis.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .arrays import Array, Points, Vector, frozen
from .depth import DepthCamera

SENSORS = frozenset({"radar", "range", "colour"})
"""What a system may ask for besides depth (`Avoidance.needs`)."""


@dataclass(frozen=True, slots=True, eq=False)
class Radar:
    """A millimetre-wave radar on the body."""

    range_max: float  # m
    width: float  # rad, full field of view across
    height: float  # rad, full field of view up and down
    rate: float  # Hz
    body_from_radar: Array = field(default_factory=lambda: np.eye(3))  # (3, 3) rotation
    position_body: Vector = field(default_factory=lambda: np.zeros(3))  # (3,) m

    def __post_init__(self) -> None:
        turn = frozen(self.body_from_radar, (3, 3), "body_from_radar")
        object.__setattr__(self, "body_from_radar", turn)
        object.__setattr__(self, "position_body", frozen(self.position_body, (3,), "position"))


@dataclass(frozen=True, slots=True, eq=False)
class RadarScan:
    """The reflections of one radar cycle."""

    time: float  # s, flight clock
    returns: Array  # (n, 4) range m, azimuth rad (+ left), elevation rad (+ up), radial speed m/s
    radar: Radar

    def __post_init__(self) -> None:
        rows = _measured(self.returns, (None, 4), "radar returns")
        if not np.isfinite(rows[:, :3]).all():
            raise ValueError("radar returns: a range or an angle is not finite")
        object.__setattr__(self, "returns", rows)

    @property
    def points_body(self) -> Points:
        """(n, 3) m: where the reflections are. Radial speeds are + away from the radar, NaN where
        the sensor does not measure them."""
        far, azimuth, elevation = self.returns[:, :3].T
        flat = far * np.cos(elevation)
        along = [flat * np.cos(azimuth), flat * np.sin(azimuth), far * np.sin(elevation)]
        points: Points = np.column_stack(along) @ self.radar.body_from_radar.T
        return points + self.radar.position_body


@dataclass(frozen=True, slots=True, eq=False)
class Beams:
    """Single-point rangefinders fixed to the body."""

    names: tuple[str, ...]
    places_body: Points  # (k, 3) m
    directions_body: Points  # (k, 3) unit
    range_max: float  # m
    rate: float  # Hz

    def __post_init__(self) -> None:
        count = len(self.names)
        for name in ("places_body", "directions_body"):
            object.__setattr__(self, name, frozen(getattr(self, name), (count, 3), name))
        if not np.allclose(np.linalg.norm(self.directions_body, axis=1), 1.0):
            raise ValueError("directions_body: not unit vectors")


@dataclass(frozen=True, slots=True, eq=False)
class RangeScan:
    """What all beams measured at one time."""

    time: float  # s, flight clock
    ranges: Array  # (k,) m; inf: nothing within reach
    beams: Beams

    def __post_init__(self) -> None:
        ranges = _measured(self.ranges, (len(self.beams.names),), "ranges")
        if np.isnan(ranges).any() or (ranges < 0).any():
            raise ValueError("ranges: NaN or negative")
        object.__setattr__(self, "ranges", ranges)


@dataclass(frozen=True, slots=True, eq=False)
class ColourFrame:
    """One colour image, pixel by pixel on the depth camera's."""

    time: float  # s, flight clock, middle of the exposure
    rgb: NDArray[np.uint8]  # (h, w, 3)
    camera: DepthCamera


SensorScan = RadarScan | RangeScan | ColourFrame


@dataclass(frozen=True, slots=True, eq=False)
class Sensed:
    """The newest of each sensor; None: not fitted, or nothing came yet."""

    radar: RadarScan | None = None
    range: RangeScan | None = None
    colour: ColourFrame | None = None

    def scans(self) -> tuple[SensorScan, ...]:
        """Those that there are."""
        every = (self.radar, self.range, self.colour)
        return tuple(scan for scan in every if scan is not None)

    def after(self, scan: SensorScan) -> Sensed:
        """With `scan` in the place of the older one of its kind."""
        match scan:
            case RadarScan():
                return Sensed(scan, self.range, self.colour)
            case RangeScan():
                return Sensed(self.radar, scan, self.colour)
            case ColourFrame():
                return Sensed(self.radar, self.range, scan)


def plant_protection_radar(reach: float) -> Radar:
    """Ahmed 2022, Table 2 (S0): 30 m, 50° x 20°, 10 Hz; `reach` m before the body's centre."""
    width, height = np.radians(50.0), np.radians(20.0)
    return Radar(30.0, float(width), float(height), 10.0, position_body=np.array([reach, 0.0, 0.0]))


def corner_lasers(reach: float) -> Beams:
    """Ahmed 2022, Fig. 5 and Table 2: S1 front left and S3 front right look ahead, S2 back left
    looks left, S4 back right looks right; 5 m, 10 Hz. On arms that end at (±reach, ±reach)."""
    return Beams(
        names=("S1", "S2", "S3", "S4"),
        places_body=reach * np.array([[1, 1, 0], [-1, 1, 0], [1, -1, 0], [-1, -1, 0]]),
        directions_body=np.array([[1, 0, 0], [0, 1, 0], [1, 0, 0], [0, -1, 0]]),
        range_max=5.0,
        rate=10.0,
    )


def _measured(values: ArrayLike, shape: tuple[int | None, ...], what: str) -> Array:
    """A read-only copy that may hold inf or NaN; ValueError when the shape is wrong."""
    array = np.array(values, dtype=np.float64)
    if array.size == 0 and shape[0] is None:
        array = array.reshape(0, *(side or 0 for side in shape[1:]))
    fits = array.ndim == len(shape) and all(
        want is None or got == want for got, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        raise ValueError(f"{what}: shape {array.shape}")
    array.setflags(write=False)
    return array
