"""The site frame of planted rows: where its origin is, and which way x points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from orchard_cli.errors import Fault
from orchard_cli.geometry.geodesy import site_from_wgs84, wgs84_from_site
from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.site import HeightReference, SiteOrigin

from .features import Drawing
from .given import Given
from .planting import Planted, Planting, mean_direction

_TURNED = math.radians(10.0)  # most between a given heading and the rows
_MICRONS = 6  # decimals of a metre

Tables = dict[str, Any]


def towards_of(given: Given) -> float | None:
    """The rows' direction in the plane, rad from east towards north, where it is given."""
    return None if given.heading_deg is None else math.pi / 2 - math.radians(given.heading_deg)


class Site:
    """The site frame of the rows: origin, heading, and the way there from the plane."""

    def __init__(
        self,
        rows: Planting,
        plane: SiteOrigin,
        drawing: Drawing,
        given: Given,
        faults: list[Fault],
    ) -> None:
        self._plane, self._given = plane, given
        direction = self._direction(rows, drawing, faults)
        _put_in_order(rows, direction)
        first = rows.rows[0]
        self.altitude = float(first.altitudes[0]) if _has_altitudes(rows.rows, faults) else None
        self._height = self._ground_height(drawing.file, faults)
        place = wgs84_from_site(plane, np.array([[*first.places[0], 0.0]]))[0]
        self._origin = self._turned(place, math.pi / 2)
        if given.heading_deg is not None:
            heading = math.radians(given.heading_deg)
        else:
            turned = [
                Planted(r.where, self._moved(r.places), r.heights, r.altitudes) for r in rows.rows
            ]
            exact = mean_direction(turned)
            exact += math.pi * round((direction - exact) / math.pi)
            heading = (math.pi / 2 - exact) % (2 * math.pi)
        self._origin = self._turned(place, heading)

    def _turned(self, place: Array, heading: float) -> SiteOrigin:
        latitude, longitude = (float(degrees) for degrees in place[:2])
        return SiteOrigin(latitude, longitude, self._height, HeightReference.AMSL, heading)

    def _direction(self, rows: Planting, drawing: Drawing, faults: list[Fault]) -> float:
        """Of +x in the plane: as given, or such that the file's first tree is the origin, or the
        heading between 0 and 180°."""
        direction = mean_direction(rows.rows)
        towards = towards_of(self._given)
        if towards is not None:
            off = (direction - towards + math.pi / 2) % math.pi - math.pi / 2
            if abs(off) > _TURNED:
                faults.append(
                    Fault(drawing.file, f"the rows run {abs(math.degrees(off)):.0f}° off the "
                          "heading given", "give the heading along the rows")
                )  # fmt: skip
            return towards
        eastward = direction if math.cos(direction) > 1e-9 else direction - math.pi
        if math.cos(eastward) < 1e-9:  # along north
            eastward = math.pi / 2
        first = min(
            (math.hypot(*row.places[end]), turn)
            for turn in (0.0, math.pi)
            for row, end in [_corner(rows.rows, eastward + turn)]
        )
        return eastward + (first[1] if first[0] < 1e-6 else 0.0)

    def _ground_height(self, file: str, faults: list[Fault]) -> float:
        """m above the sea at the first tree."""
        if self._given.ground_height_m is not None:
            return self._given.ground_height_m
        if self.altitude is None:
            faults.append(
                Fault(file, "the ground's height above the sea is not told",
                      "give that at the first tree with --ground-height")
            )  # fmt: skip
        return self.altitude or 0.0

    def _moved(self, places: Points) -> Points:
        flat = np.column_stack([places, np.full(len(places), 0.0)])
        moved: Points = site_from_wgs84(self._origin, wgs84_from_site(self._plane, flat))[:, :2]
        return moved

    def places(self, places: Points) -> Points:
        """(n, 2) m in the plane -> in the site frame, to the micron."""
        moved: Points = np.round(self._moved(places), _MICRONS) + 0.0
        return moved

    def ring(self, places: Points) -> list[list[float]]:
        """Corners in the site frame."""
        corners: list[list[float]] = self.places(places).tolist()
        return corners

    def ground(self, altitudes: Array) -> Array:
        """Of (n,) m above the sea: above the ground at the origin; 0 where no tree tells any."""
        if self.altitude is None:
            return np.zeros(len(altitudes))
        ground: Array = np.round(altitudes - self.altitude, _MICRONS) + 0.0
        return ground

    def table(self) -> Tables:
        """[site]."""
        return {
            **self._given.settings.get("site", {}),
            "latitude_deg": self._origin.latitude_deg,
            "longitude_deg": self._origin.longitude_deg,
            "height_m": self._height,
            "heading_deg": round(math.degrees(self._origin.heading), 9),
        }

    def row(self, row: Planted) -> Tables:
        """[[row]]."""
        table: Tables = {
            "trunks_m": self.ring(row.places),
            "tree_height_m": _one_or_many(row.heights),
        }
        if self.altitude is not None:
            table["ground_m"] = _one_or_many(self.ground(row.altitudes))
        return table


def _one_or_many(values: Array) -> float | list[float]:
    listed: list[float] = values.tolist()
    return listed[0] if len(set(listed)) == 1 else listed


def _corner(rows: Sequence[Planted], direction: float) -> tuple[Planted, int]:
    """The row farthest right of a direction, and which of its ends (0, -1) comes first."""
    along = np.array([math.cos(direction), math.sin(direction)])
    left = np.array([-along[1], along[0]])
    row = min(rows, key=lambda r: float((r.places @ left).mean()))
    return row, 0 if row.places[0] @ along <= row.places[-1] @ along else -1


def _put_in_order(rows: Planting, direction: float) -> None:
    """Rows from right to left, the trees of each along the direction."""
    along = np.array([math.cos(direction), math.sin(direction)])
    left = np.array([-along[1], along[0]])
    rows.rows.sort(key=lambda r: float((r.places @ left).mean()))
    rows.rows[:] = [
        row
        if row.places[0] @ along <= row.places[-1] @ along
        else Planted(row.where, row.places[::-1], row.heights[::-1], row.altitudes[::-1])
        for row in rows.rows
    ]


def _has_altitudes(rows: Sequence[Planted], faults: list[Fault]) -> bool:
    """Whether trees tell the ground's height; files that do not know it write 0 everywhere."""
    told = np.concatenate([row.altitudes for row in rows])
    if np.isnan(told).all() or not np.nan_to_num(told).any():
        return False
    if np.isnan(told).any():
        faults.append(
            Fault(rows[0].where, f"{np.isnan(told).sum()} trees tell no ground height, others do",
                  "give it for all trees or for none")
        )  # fmt: skip
    return True
