"""The wind at the vehicle."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.model.world import Wind


class Gusts:
    """Mean wind and a first-order Gauss-Markov gust on each horizontal axis, seeded."""

    def __init__(self, wind: Wind, dt: float, rng: np.random.Generator) -> None:
        self._mean = np.array(wind.velocity_site)
        self._keep = math.exp(-dt / wind.gust_time)
        self._kick = wind.gust * math.sqrt(1 - self._keep**2)
        self._rng = rng
        self._gust = wind.gust * rng.standard_normal(2)

    def blow(self, velocity_site: Vector) -> None:
        """Change the mean, m/s; the gusts go on."""
        self._mean = np.array(velocity_site)

    def step(self) -> Vector:
        """(3,) m/s, towards where the air moves, for the next `dt`."""
        self._gust = self._keep * self._gust + self._kick * self._rng.standard_normal(2)
        air = self._mean.copy()
        air[:2] += self._gust
        return air
