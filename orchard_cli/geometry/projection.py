"""Places on earth in the coordinate reference systems of maps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from pyproj import CRS, Transformer
from pyproj.exceptions import ProjError

from orchard_cli.model.arrays import Array, Points


@dataclass(frozen=True, slots=True)
class MapProjection:
    """East and north (or longitude and latitude, degrees) of a reference system, both ways."""

    name: str
    _map_from_wgs84: Any

    @staticmethod
    def of_epsg(code: int) -> MapProjection:
        """By its number in the EPSG register. Raises ValueError for one that is of no use."""
        try:
            crs = CRS.from_epsg(code)
            there = Transformer.from_crs(4326, crs, always_xy=True, allow_ballpark=False)
        except ProjError as error:
            raise ValueError(f"EPSG:{code} cannot be reached from WGS84") from error
        return MapProjection(crs.name, there)

    def map_from_wgs84(self, places_wgs84: Array) -> Points:
        """(n, 2 or 3) latitude deg, longitude deg -> (n, 2) in the map's own unit."""
        latitude, longitude = np.asarray(places_wgs84, dtype=np.float64).T[:2]
        return np.column_stack(self._map_from_wgs84.transform(longitude, latitude))

    def wgs84_from_map(self, points: Points) -> Array:
        """(n, 2) in the map's own unit -> (n, 2) latitude deg, longitude deg."""
        x, y = np.asarray(points, dtype=np.float64).T
        longitude, latitude = self._map_from_wgs84.transform(x, y, direction="INVERSE")
        return np.column_stack([latitude, longitude])
