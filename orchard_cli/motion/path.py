"""The path ahead, and where on it an obstacle stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.trajectory import Trajectory

STEP = 0.1  # m of travel between samples at full speed


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """Places along a way to be flown."""

    points_site: Points  # (n, 3) m, n >= 2, no two neighbours alike
    lengths: Array  # (n,) m, horizontal, from the first

    @classmethod
    def through(cls, points_site: Points) -> Path:
        """Of places in order; those that repeat the one before are left out. The last one stays
        when all are the same."""
        steps = np.hypot(*np.diff(points_site[:, :2], axis=0).T)
        kept = points_site[np.concatenate([[True], steps > 1e-6])]
        if len(kept) < 2:
            kept = np.vstack([kept[:1], kept[:1]])
        steps = np.hypot(*np.diff(kept[:, :2], axis=0).T)
        return cls(kept, np.concatenate([[0.0], np.cumsum(steps)]))

    @classmethod
    def of(cls, trajectory: Trajectory, begin: float, length: float, speed: float) -> Path:
        """What a trajectory flies from time `begin` on, at least `length` m of it where it is as
        long; `speed` m/s is its fastest."""
        times = np.arange(begin, max(trajectory.end, begin) + STEP, STEP / speed)
        first = min(len(times), int(3 * length / STEP))
        path = cls.through(trajectory.sample(times[:first])[0])
        return path.upto(length)

    def upto(self, length: float) -> Path:
        """The first `length` m."""
        n = max(int(np.searchsorted(self.lengths, length)) + 1, 2)
        return Path(self.points_site[:n], self.lengths[:n])

    def at(self, length: float) -> Vector:
        """(3,) m: the place after `length` m; beyond an end, straight on."""
        inside = min(max(length, 0.0), float(self.lengths[-1]))
        place = np.array([np.interp(inside, self.lengths, axis) for axis in self.points_site.T])
        place[:2] += (length - inside) * self.direction(inside)
        return place

    def direction(self, length: float) -> Vector:
        """(2,) unit: the course after `length` m."""
        i = int(np.clip(np.searchsorted(self.lengths, length) - 1, 0, len(self.lengths) - 2))
        way = self.points_site[i + 1, :2] - self.points_site[i, :2]
        norm = float(np.hypot(*way))
        return np.asarray(way / norm) if norm > 0 else np.zeros(2)

    def beside(self, place_site: Vector) -> tuple[float, float]:
        """m along the path to where it passes a place nearest, and m by which the place lies to
        the left of it there.

        0 along: it is behind the beginning.
        """
        a, way = self.points_site[:-1, :2], np.diff(self.points_site[:, :2], axis=0)
        squared = np.maximum((way**2).sum(axis=1), 1e-12)
        share = np.clip(((place_site[:2] - a) * way).sum(axis=1) / squared, 0.0, 1.0)
        offset = place_site[:2] - (a + share[:, None] * way)
        apart = np.hypot(*offset.T)
        i = int(np.argmin(apart))
        left = way[i, 0] * offset[i, 1] - way[i, 1] * offset[i, 0]
        along = float(self.lengths[i] + share[i] * np.sqrt(squared[i]))
        return along, float(np.copysign(apart[i], left))
