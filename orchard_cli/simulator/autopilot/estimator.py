"""What the autopilot believes: the truth and a slow error of each estimate."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Array, Vector
from orchard_cli.model.world import SensorNoise
from orchard_cli.simulator.body import Body, Normals

from . import _kernels
from .seen import Seen

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
        self._normals = Normals(rng, 9)
        self.error: Array = np.zeros(9)
        """(9,) of what was seen last: position m, velocity m/s, small turn rad, in the site."""
        position = np.array([noise.position, noise.position, noise.height])
        raw = position * math.sqrt((POSITION_TIME + SMOOTHING) / POSITION_TIME)
        sigma = np.concatenate([raw, np.full(3, noise.velocity), np.full(3, noise.attitude)])
        times = np.repeat([POSITION_TIME, VELOCITY_TIME, ATTITUDE_TIME], 3)
        keep = np.exp(-dt / times)
        flat = self._flat = np.zeros((6, 9))
        flat[_kernels.KEEP], flat[_kernels.KICK] = keep, sigma * np.sqrt(1 - keep**2)
        flat[_kernels.FOLLOW] = 1 - math.exp(-dt / SMOOTHING)
        # The filtered error's variance is its covariance with the raw one, both `position`².
        share = (position / raw) ** 2 if noise.position and noise.height else np.zeros(3)
        driven = flat[_kernels.DRIVEN] = sigma * rng.standard_normal(9)
        spread = position * np.sqrt(1 - share)
        flat[_kernels.POSITION, :3] = share * driven[:3] + spread * rng.standard_normal(3)

    def jump(self, moved_site: Vector, turned: float) -> None:
        """Be off by so much more, m and rad of heading, from now on: a reset of the estimate."""
        jumped = self._flat[_kernels.JUMPED]
        jumped[:3] += moved_site
        jumped[8] += 2 * math.tan(turned / 2)

    def look(self, body: Body, time: float) -> Seen:
        """What the autopilot believes of a body, `dt` after it looked last."""
        seen = np.empty(16)
        _kernels.look(body.state, body.around, self._flat, self._normals.next(), self.error, seen)
        return Seen.of(time, seen)
