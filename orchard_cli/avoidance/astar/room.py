"""Obstacles as the search needs them: a grid of distances, of two or three dimensions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, map_coordinates

from orchard_cli.mapping import Band, OccupancyGrid, distance_field
from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.obstacles import Upright

Blocked = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """How far each cell is from the nearest obstacle, up to `reach`. Heights count `stretch` times
    as much; in two dimensions they do not count."""

    origin_site: Vector  # (d,) m, lower corner of cell [0, ...]
    cell: float  # m
    apart: Array  # (nx, ny) or (nx, ny, nz) m
    reach: float  # m

    @property
    def dimensions(self) -> int:
        """2 or 3."""
        return int(self.apart.ndim)

    def at(self, places_site: Points) -> Array:
        """m from places (n, 3) to the nearest obstacle; `reach` outside the grid."""
        index = (places_site[:, : self.dimensions] - self.origin_site) / self.cell - 0.5
        found: Array = map_coordinates(
            self.apart, index.T, order=1, mode="constant", cval=self.reach
        )
        return found

    def index(self, place_site: Vector) -> NDArray[np.int32]:
        """The cell (d,) of a place (3,); the nearest when it lies outside."""
        cell = np.floor((place_site[: self.dimensions] - self.origin_site) / self.cell)
        return np.clip(cell, 0, np.array(self.apart.shape) - 1).astype(np.int32)

    def centres(self, cells: NDArray[np.int32]) -> Points:
        """(n, d) m of cells (n, d)."""
        return np.asarray(self.origin_site + (cells + 0.5) * self.cell)

    def blocked(self, margin: float, start_site: Vector) -> Blocked:
        """Cells nearer than `margin` to an obstacle. From a start that is too near itself the way
        out is open: cells around it that are no nearer."""
        near: Blocked = self.apart < margin
        here = self.index(start_site)
        own = float(self.apart[tuple(here)])
        if own < margin:
            reach = int(np.ceil(2 * margin / self.cell))
            around = tuple(slice(max(i - reach, 0), i + reach + 1) for i in here.tolist())
            near[around] &= self.apart[around] < max(own - self.cell / 2, self.cell / 2)
        return near


def flat_room(
    grid: OccupancyGrid,
    fused: Sequence[Upright],
    centre_site: Vector,
    half_size: float,
    heights: tuple[float, float],
    reach: float,
) -> Room:
    """The band of the map between two heights, seen from above, with what fusion found there."""
    band = grid.band(centre_site, half_size, *heights)
    if fused:
        occupied = band.occupied.copy()
        for one in fused:
            if one.top >= heights[0] and one.bottom <= heights[1]:
                occupied |= _disc(occupied.shape, band.origin_site, band.cell, one)
        band = Band(band.origin_site, band.cell, occupied, band.observed, *heights)
    field = distance_field(band, reach)
    return Room(band.origin_site, band.cell, field.values.astype(np.float64), field.reach)


def high_room(
    grid: OccupancyGrid,
    fused: Sequence[Upright],
    low_site: Vector,
    high_site: Vector,
    stretch: float,
    reach: float,
) -> Room:
    """A box of the map, with what fusion found there."""
    around = np.array([0.0, 0.0, reach / stretch])
    window = grid.window(low_site - around, high_site + around)
    occupied, cell = window.occupied.copy(), window.cell
    levels = window.origin_site[2] + (np.arange(occupied.shape[2]) + 0.5) * cell
    for one in fused:
        disc = _disc(occupied.shape[:2], window.origin_site[:2], cell, one)
        occupied |= disc[:, :, None] & ((levels >= one.bottom) & (levels <= one.top))
    apart = np.full(occupied.shape, reach)
    if occupied.any():
        found = distance_transform_edt(~occupied, sampling=(cell, cell, cell * stretch))
        apart = np.minimum(found, reach)
    first = int(np.searchsorted(levels, low_site[2] - cell / 2))
    last = max(int(np.searchsorted(levels, high_site[2] + cell / 2)), first + 1)
    origin = window.origin_site + np.array([0.0, 0.0, first * cell])
    return Room(origin, cell, np.ascontiguousarray(apart[:, :, first:last]), reach)


def _disc(shape: tuple[int, ...], origin: Vector, cell: float, one: Upright) -> Blocked:
    x, y = (origin[k] + (np.arange(shape[k]) + 0.5) * cell - one.centre_site[k] for k in (0, 1))
    inside: Blocked = np.hypot(x[:, None], y[None]) <= one.width / 2 + cell / 2
    return inside
