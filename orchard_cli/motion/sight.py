"""What of a trajectory the camera has looked at: nothing else may be flown."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.mapping import Band
from orchard_cli.model.trajectory import DEGREE, Trajectory

from . import _kernels
from .situation import Situation

_GAP = 0.5  # m not looked at between what was, that do not count
_MARGIN = 1.0  # m of map around a trajectory
_HALF_HEIGHT = 0.3  # m of map over and under it


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """The map and the camera's view now, both seen from above.

    Looked at is what the map has observed, and what lies in the camera's view now: rays that end
    in the sky return nothing, and so clear nothing in the map.
    """

    situation: Situation
    band: Band | None = None  # of the map around all that is asked for; None: taken when asked

    def looked(self, trajectory: Trajectory, begin: float, end: float) -> float:
        """Path length from time `begin` to the first stretch not looked at yet, m; inf when all
        was looked at until `end`. Gaps under half a metre do not count."""
        first, last = (
            (min(max(time, trajectory.start), trajectory.end) - trajectory.start)
            / trajectory.interval
            for time in (begin, end)
        )
        if last <= first:
            return math.inf
        vehicle, camera = self.situation.vehicle, self.situation.frame.camera
        band = self.band or self._around(trajectory, first, last)
        x, y = vehicle.position_site[:2]
        yaw = vehicle.yaw_site
        eye = np.array(
            [x, y, math.cos(yaw), math.sin(yaw), camera.range_max, camera.width / (2 * camera.fx)]
        )
        return float(
            _kernels.looked(
                trajectory.control_points_site, trajectory.interval, first, last,
                band.observed, band.origin_site, band.cell, eye, _GAP,
            )
        )  # fmt: skip

    def looks_ahead(self, trajectory: Trajectory, begin: float, speed: float) -> bool:
        """Whether the camera has looked at all that full braking from `speed` would cross.

        Braking bites one interval after its knot; each frame asks again, up to the last before it.
        """
        limit = self.situation.limits.acceleration
        needed = speed**2 / (2 * limit) + speed * trajectory.interval
        return self.looked(trajectory, begin, begin + 2 * needed / max(speed, 0.1)) >= needed

    def _around(self, trajectory: Trajectory, first: float, last: float) -> Band:
        """The map around the segments `first` to `last`: their curve is within their polygon."""
        points = trajectory.control_points_site[int(first) : math.ceil(last) + DEGREE]
        low, high = points.min(axis=0), points.max(axis=0)
        half = float(np.max(high - low)) / 2 + _MARGIN
        return self.situation.grid.band(
            (low + high)[:2] / 2, half, float(low[2]) - _HALF_HEIGHT, float(high[2]) + _HALF_HEIGHT
        )
