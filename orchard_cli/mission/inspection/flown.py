"""The trajectory as it will be flown: sampled by SciPy's splines, not by the planner's own code."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.trajectory import Trajectory

STEP = 0.05  # s between samples: 5 cm at 1 m/s
_CREEP = 0.05  # m/s: slower than this the direction of travel means nothing


@dataclass(frozen=True, slots=True, eq=False)
class Flown:
    """Samples of a flight, STEP apart in time."""

    times: Array  # (n,) s since the start
    positions: Points  # (n, 3) m, site frame
    velocities: Points  # (n, 3) m/s
    accelerations: Points  # (n, 3) m/s²

    @property
    def speeds(self) -> Array:
        """(n,) m/s."""
        speeds: Array = np.linalg.norm(self.velocities, axis=1)
        return speeds

    @property
    def accelerations_along(self) -> Array:
        """(n,) m/s², the part along the direction of travel, of either sign taken positive."""
        along = np.einsum("ij,ij->i", self.velocities, self.accelerations)
        return np.asarray(np.abs(along) / np.maximum(self.speeds, 1e-9))

    @property
    def curvatures(self) -> Array:
        """(n,) 1/m: |v x a| / |v|³; 0 where it all but stands."""
        speeds = self.speeds
        turn = np.linalg.norm(np.cross(self.velocities, self.accelerations), axis=1)
        return np.where(speeds >= _CREEP, turn / np.maximum(speeds, _CREEP) ** 3, 0.0)

    @property
    def yaw_rates(self) -> Array:
        """(n,) rad/s by which the direction of travel, seen from above, turns either way."""
        flat = np.hypot(self.velocities[:, 0], self.velocities[:, 1])
        headings = np.unwrap(np.arctan2(self.velocities[:, 1], self.velocities[:, 0]))
        rates = np.abs(np.gradient(headings, self.times))
        moving = (flat >= _CREEP) & (np.roll(flat, 1) >= _CREEP) & (np.roll(flat, -1) >= _CREEP)
        return np.where(moving, rates, 0.0)


def flown(trajectory: Trajectory) -> Flown:
    """Sample a whole trajectory, both ends included."""
    control = trajectory.control_points_site
    knots = trajectory.start + trajectory.interval * (np.arange(len(control) + 4) - 3.0)
    curve = BSpline(knots, control, 3)
    first, last = float(knots[3]), float(knots[len(control)])
    times = np.linspace(first, last, max(int(np.ceil((last - first) / STEP)), 2) + 1)
    return Flown(
        times,
        np.asarray(curve(times)),
        np.asarray(curve.derivative()(times)),
        np.asarray(curve.derivative(2)(times)),
    )
