"""The wind at the vehicle."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Array, Vector
from orchard_cli.model.world import Wind

from . import _kernels
from .normals import Normals


class Gusts:
    """Mean wind and a first-order Gauss-Markov gust on each horizontal axis, seeded."""

    def __init__(self, wind: Wind, dt: float, rng: np.random.Generator) -> None:
        keep = math.exp(-dt / wind.gust_time)
        kick = wind.gust * math.sqrt(1 - keep**2)
        self._normals = Normals(rng, 2)
        gust = wind.gust * self._normals.next()
        self._air = np.array([*wind.velocity_site, *gust, keep, kick])

    def blow(self, velocity_site: Vector) -> None:
        """Change the mean, m/s; the gusts go on."""
        self._air[:3] = velocity_site

    def step(self, around: Array) -> None:
        """Into the first three of `around`: m/s, to where the air moves, for the next `dt`."""
        _kernels.blow(self._air, self._normals.next(), around)
