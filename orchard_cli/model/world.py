"""The world that the simulator flies in and that analysis measures clearance against.

Everything stands in the site frame, metres; the ground is the plane z = 0 unless trees say more.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .arrays import Vector, frozen


@dataclass(frozen=True, slots=True)
class Tree:
    """A trunk (upright cylinder) under a canopy (ellipsoid)."""

    x: float
    y: float
    ground: float = 0.0  # m, z of the ground at the trunk
    height: float = 2.6  # m, canopy top above that ground
    canopy_radius: float = 1.2  # m, horizontal
    canopy_height: float = 2.0  # m, from the canopy's bottom to its top
    trunk_radius: float = 0.08  # m


@dataclass(frozen=True, slots=True)
class Pole:
    """An upright cylinder from the ground up."""

    x: float
    y: float
    radius: float
    height: float
    ground: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Wire:
    """A wire between two ends, hanging as a parabola `sag` metres below its chord at mid-span."""

    a_site: Vector  # (3,) m
    b_site: Vector  # (3,) m
    sag: float
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "a_site", frozen(self.a_site, (3,), "wire end a"))
        object.__setattr__(self, "b_site", frozen(self.b_site, (3,), "wire end b"))


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """A box turned about its upright axis."""

    centre_site: Vector  # (3,) m
    size: Vector  # (3,) m, full lengths
    yaw: float  # rad, counter-clockwise from +x

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre_site", frozen(self.centre_site, (3,), "box centre"))
        object.__setattr__(self, "size", frozen(self.size, (3,), "box size"))


@dataclass(frozen=True, slots=True, eq=False)
class Person:
    """Walks from a to b and back at a speed: an upright capsule."""

    a_site: Vector  # (2,) m
    b_site: Vector  # (2,) m
    speed: float  # m/s
    radius: float = 0.3
    height: float = 1.75
    start: float = 0.0  # s, when the walk begins

    def __post_init__(self) -> None:
        object.__setattr__(self, "a_site", frozen(self.a_site, (2,), "walk start"))
        object.__setattr__(self, "b_site", frozen(self.b_site, (2,), "walk end"))


@dataclass(frozen=True, slots=True, eq=False)
class Wind:
    """Mean wind and gusts, a first-order Gauss-Markov process per axis."""

    velocity_site: Vector = field(default_factory=lambda: np.zeros(3))  # (3,) m/s, towards
    gust: float = 0.0  # m/s, standard deviation of each horizontal axis
    gust_time: float = 3.0  # s, correlation time

    def __post_init__(self) -> None:
        object.__setattr__(self, "velocity_site", frozen(self.velocity_site, (3,), "wind"))


@dataclass(frozen=True, slots=True)
class SensorNoise:
    """How good the simulated sensors are; standard deviations."""

    disparity_px: float = 0.1  # px, stereo matching: depth noise grows with depth squared
    dropout: float = 0.002  # share of pixels without a return, besides edges and sky
    position: float = 0.1  # m, slow error of the estimated horizontal position
    height: float = 0.05  # m, slow error of the estimated height
    velocity: float = 0.03  # m/s
    attitude: float = 0.003  # rad
    radar_range: float = 0.05  # m
    radar_angle: float = 0.009  # rad, azimuth; elevation twice that
    radar_speed: float = 0.1  # m/s
    radar_miss: float = 0.05  # share of the reflections that are not reported
    radar_clutter: float = 0.1  # reflections of nothing, mean of a scan
    laser_range: float = 0.02  # m


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """Everything that can be hit or seen, the wind, and the quality of the sensors."""

    name: str
    trees: tuple[Tree, ...] = ()
    poles: tuple[Pole, ...] = ()
    wires: tuple[Wire, ...] = ()
    boxes: tuple[Box, ...] = ()
    people: tuple[Person, ...] = ()
    wind: Wind = field(default_factory=Wind)
    noise: SensorNoise = field(default_factory=SensorNoise)
    seed: int = 0
