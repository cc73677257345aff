"""Sheets of tree positions: one line a tree, in site metres or in degrees.

    # [site]                     as in sheet.py; for metres, where 0, 0 is and where x points
    x_m,y_m,ground_m,tree_height_m,row
    0.0,0.0,0.0,2.3,1

Columns, in small or capital letters: x_m, y_m, or latitude_deg, longitude_deg (lat, lon); ground_m
(z) in metres above the ground at 0, 0, or altitude_m above the sea beside degrees; and what a
feature of a drawing may tell: tree_height_m, row, name, kind, radius_m, height_m.
"""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.geometry.geodesy import wgs84_from_site
from orchard_cli.model.site import SiteOrigin

from .features import MOST_FEATURES, Drawing, Feature, Shape, Value, properties_of
from .reading import Table
from .sheet import Line, values

_NAMES = {
    "x": ("x_m", "x"),
    "y": ("y_m", "y"),
    "latitude": ("latitude_deg", "latitude", "lat"),
    "longitude": ("longitude_deg", "longitude", "lon", "lng", "long"),
    "ground": ("ground_m", "z_m", "z", "altitude_m", "altitude", "alt", "elevation_m",
               "elevation", "ele"),
}  # fmt: skip
_REACH = 10_000.0  # m from 0, 0


def columns_of(lines: list[Line]) -> dict[str, str]:
    """Which column tells what, by the sheet's first line; empty when it tells no positions."""
    names = [name.lower() for name in lines[0][1]] if lines else []
    found = {
        what: next(name for name in known if name in names)
        for what, known in _NAMES.items()
        if any(name in names for name in known)
    }
    whole = {"x", "y"} <= found.keys() or {"latitude", "longitude"} <= found.keys()
    return found if whole else {}


def in_metres(columns: dict[str, str]) -> bool:
    """Whether positions are told in site metres."""
    return "latitude" not in columns


def read(lines: list[Line], file: str, plane: SiteOrigin | None) -> Drawing:
    """The trees of a sheet; `plane` is the frame of positions in metres.

    Raises InputError with its faults.
    """
    columns = columns_of(lines)
    names = [name.lower() for name in lines[0][1]]
    if len(lines) > MOST_FEATURES:
        raise InputError(Fault(file, f"has more than {MOST_FEATURES} trees", "split it"))
    if len(set(names)) < len(names):
        raise InputError(Fault(f"{file}: line {lines[0][0]}", "has a column twice", "rename one"))
    keys = ("latitude", "longitude") if plane is None else ("x", "y")
    faults: list[Fault] = []
    positions, told = [], []
    for number, cells in lines[1:]:
        table = Table(values(names, cells), f"{file}: line {number}", faults)
        if len(cells) > len(names):
            table.fault("", f"has {len(cells)} cells for {len(names)} columns", "remove some")
        reach = (90.0, 180.0) if plane is None else (_REACH, _REACH)
        place = [table.number(columns[k], -r, r) for k, r in zip(keys, reach, strict=True)]
        ground = columns.get("ground")
        height = table.number(ground, -500, 9_000, math.nan) if ground else math.nan
        positions.append([*place, height])
        told.append((table.where, _properties(names, cells, set(columns.values()))))
    if faults:
        raise InputError(faults)
    places = np.array(positions).reshape(-1, 3)
    if plane is not None and len(places):
        places = _on_earth(plane, places)
    return Drawing(
        file,
        tuple(
            Feature(where, Shape.POINT, (place[None],), str(p.get("name", "")), (), p)
            for (where, p), place in zip(told, places, strict=True)
        ),
    )


def _on_earth(plane: SiteOrigin, places: np.ndarray) -> np.ndarray:
    """(n, 3) x, y, ground above the plane's → latitude, longitude, height; untold stays untold."""
    flat = np.column_stack([places[:, :2], np.zeros(len(places))])
    earth = wgs84_from_site(plane, flat)
    return np.column_stack([earth[:, :2], plane.height + places[:, 2]])


def _properties(names: list[str], cells: list[str], used: set[str]) -> dict[str, Value]:
    return properties_of({k: v for k, v in values(names, cells).items() if k not in used})
