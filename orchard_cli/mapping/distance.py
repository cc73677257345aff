"""How far every place of a band is from the nearest obstacle cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.arrays import Array, Points, Vector

from . import _kernels
from .band import Band, as_input


@dataclass(frozen=True, slots=True, eq=False)
class DistanceField:
    """Horizontal distance to the nearest occupied cell of a band, known up to `reach`.

    Values are exact between cell centres: 0 in an occupied cell, one cell beside it; the surface
    itself may be up to half a cell's diagonal (0.07 m at 0.1 m cells) nearer. Between centres it
    is interpolated bilinearly. Beyond the band the distance is `reach`: what is not in the band
    is not an obstacle here.
    """

    values: NDArray[np.float32]  # (nx, ny) m, C-contiguous, [ix, iy] as in the band
    origin_site: Vector  # (2,) m, lower left corner of cell [0, 0]
    cell: float  # m
    reach: float  # m, a whole number of cells

    def at(self, points_site: Points) -> Array:
        """(n, 2) -> (n,) m."""
        return self.sample(points_site)[0]

    def gradient(self, points_site: Points) -> Points:
        """(n, 2) -> (n, 2): of the interpolated field, so that descent and `at` agree."""
        return self.sample(points_site)[1]

    def sample(self, points_site: Points) -> tuple[Array, Points]:
        """Distances (n,) and gradients (n, 2) together."""
        points = as_input(points_site, np.float64)
        if points.ndim != 2 or points.shape[1] != 2:
            raise ValueError(f"points: shape {points.shape}, expected nx2")
        distances, gradients = np.empty(len(points)), np.empty((len(points), 2))
        _kernels.sample_field(
            self.values, self.origin_site, self.cell, self.reach, points, distances, gradients
        )
        return distances, gradients


def distance_field(band: Band, reach: float) -> DistanceField:
    """The exact distance field of a band, capped at `reach` metres (rounded up to whole cells)."""
    if not 0 < reach < np.inf:
        raise ValueError("reach: a positive length")
    cells = int(np.ceil(reach / band.cell - 1e-9))
    values = np.empty(band.occupied.shape, dtype=np.float32)
    _kernels.squared_distance(band.occupied, cells, values)
    np.sqrt(values, out=values)
    values *= np.float32(band.cell)
    values.setflags(write=False)
    return DistanceField(values, band.origin_site, band.cell, cells * band.cell)
