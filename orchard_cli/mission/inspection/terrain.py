"""The ground between the trees."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import (
    LinearNDInterpolator,
    NearestNDInterpolator,
    RegularGridInterpolator,
)
from scipy.spatial import QhullError

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.site import Orchard
from orchard_cli.model.terrain import Terrain as Grid


class Terrain:
    """The mission's terrain; without one, linear between the trunks, nearest outside them."""

    def __init__(self, orchard: Orchard) -> None:
        trunks = np.concatenate([row.trunks_site for row in orchard.rows])
        ground = np.concatenate([row.ground for row in orchard.rows])
        self._grid = None if orchard.terrain is None else _grid(orchard.terrain)
        self._nearest = NearestNDInterpolator(trunks, ground)
        self._linear: LinearNDInterpolator | None = None
        if np.ptp(ground) > 0:
            try:
                self._linear = LinearNDInterpolator(trunks, ground)
            except QhullError:  # a single row: its trees lie on one line
                self._linear = None

    def ground(self, places_site: Points) -> Array:
        """z of the ground (n,) m under places (n, 2) m."""
        if self._grid is not None:
            return np.asarray(self._grid(places_site), dtype=np.float64)
        nearest = np.asarray(self._nearest(places_site), dtype=np.float64)
        if self._linear is None:
            return nearest
        linear = np.asarray(self._linear(places_site), dtype=np.float64)
        return np.where(np.isnan(linear), nearest, linear)


def _grid(terrain: Grid) -> RegularGridInterpolator:
    """NaN outside: a flight that leaves the known ground keeps no rule about it."""
    x, y = (
        terrain.corner_site[k] + terrain.step * np.arange(terrain.heights.shape[k]) for k in (0, 1)
    )
    return RegularGridInterpolator((x, y), terrain.heights, bounds_error=False)
