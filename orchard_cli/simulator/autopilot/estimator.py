"""What the autopilot believes: the truth and a slow error of each estimate."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Array, Vector
from orchard_cli.model.world import SensorNoise

POSITION_TIME = 60.0  # s, correlation time of the position error, as of GNSS multipath and drift
SMOOTHING = 3.0  # s, the filter's own lag: the position error creeps, it does not jitter
VELOCITY_TIME = 1.0  # s
ATTITUDE_TIME = 5.0  # s


class Estimator:
    """Gauss-Markov errors with the standard deviations of `SensorNoise`, stationary from the start.

    The position error is a Gauss-Markov process passed through a first-order filter, so that the
    estimate's velocity stays small, as an EKF's does between its corrections.
    """

    def __init__(self, noise: SensorNoise, dt: float, rng: np.random.Generator) -> None:
        self._rng = rng
        position = np.array([noise.position, noise.position, noise.height])
        raw = position * math.sqrt((POSITION_TIME + SMOOTHING) / POSITION_TIME)
        sigma = np.concatenate([raw, np.full(3, noise.velocity), np.full(3, noise.attitude)])
        times = np.repeat([POSITION_TIME, VELOCITY_TIME, ATTITUDE_TIME], 3)
        self._keep = np.exp(-dt / times)
        self._kick = sigma * np.sqrt(1 - self._keep**2)
        self._follow = 1 - math.exp(-dt / SMOOTHING)
        # The filtered error's variance is its covariance with the raw one, both `position`².
        share = (position / raw) ** 2 if noise.position and noise.height else np.zeros(3)
        self._driven = sigma * rng.standard_normal(9)
        spread = position * np.sqrt(1 - share)
        self._position = share * self._driven[:3] + spread * rng.standard_normal(3)
        self._jumped = np.zeros(9)

    def jump(self, moved_site: Vector, turned: float) -> None:
        """Be off by so much more, m and rad of heading, from now on: a reset of the estimate."""
        self._jumped[:3] += moved_site
        self._jumped[8] += 2 * math.tan(turned / 2)

    def step(self) -> Array:
        """(9,) for the next `dt`: position m, velocity m/s, small turn rad, in the site frame."""
        self._driven = self._keep * self._driven + self._kick * self._rng.standard_normal(9)
        self._position += self._follow * (self._driven[:3] - self._position)
        error = self._driven.copy()
        error[:3] = self._position
        return np.asarray(error + self._jumped)
