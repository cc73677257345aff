"""The inflated map around the way to the local target."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchard_cli.mapping import OccupancyGrid, Window
from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.trajectory import DEGREE, Trajectory

from .cells import _kernels

_TICK = 0.01  # s, steps of the safety check


@dataclass(frozen=True, slots=True, eq=False)
class Obstacles:
    """Inflated obstacle cells; what was never seen is free, what is outside the box is not."""

    cells: NDArray[np.bool_]  # (nx, ny, nz)
    frame: Array  # (4,) m: lower corner of cell [0, 0, 0], and the size of a cell

    def blocked(self, place_site: Vector) -> bool:
        """Whether a place (3,) is in an obstacle."""
        return bool(_kernels.is_blocked(self.cells, self.frame, *place_site))

    def first_hit(self, trajectory: Trajectory, begin: float, end: float) -> float | None:
        """When the trajectory first meets an obstacle between two times, s; None: it does not."""
        control, interval = trajectory.control_points_site, trajectory.interval
        last = float(len(control) - DEGREE)
        first, final = (
            min(max((t - trajectory.start) / interval, 0.0), last) for t in (begin, end)
        )
        hit = _kernels.first_hit(control, first, final, interval / _TICK, self.cells, self.frame)
        return None if hit < 0 else trajectory.start + hit * interval


def inflated(window: Window, inflation: float, free_site: Vector) -> Obstacles:
    """Thicken the obstacles by cubes of so many whole cells as `inflation` (m) needs.

    Where the vehicle will be, at `free_site` (3,), is not called an obstacle because of that: a
    return that appears nearby would hold it there for ever. The inflation is then less.
    """
    frame = np.append(window.origin_site, window.cell)
    cells = np.empty(window.occupied.shape, dtype=np.bool_)
    for reach in range(math.ceil(inflation / window.cell - 1e-9), -1, -1):
        _kernels.inflate(window.occupied, reach, cells)
        if not _kernels.is_blocked(cells, frame, *free_site):
            break
    return Obstacles(cells, frame)


def look(
    grid: OccupancyGrid, places_site: Points, around: float, above: float, inflation: float
) -> Obstacles:
    """The obstacles in the box around places (n, 3), the first of which is free."""
    margin = np.array([around, around, above])
    window = grid.window(places_site.min(axis=0) - margin, places_site.max(axis=0) + margin)
    return inflated(window, inflation, places_site[0])
