"""Measured flights for other programs: CSV, GeoJSON (as-applied map), TUM trajectories."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from orchard_cli.geometry.geodesy import wgs84_from_site
from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.flown import Track
from orchard_cli.model.mission import Mission

from .coverage import areas, flown_lines, planned_lines
from .figures import Unknown
from .flight import Flight

DECIMALS = 9  # of a degree: 0.1 mm


def csv_table(entries: Sequence[Mapping[str, Any]]) -> str:
    """A row for each log and a column for each metric; empty where it is not known.

    `entries`: as in the JSON document; a log that could not be measured has its reason in `error`.
    """
    columns = dict.fromkeys(name for entry in entries for name in entry.get("metrics", ()))
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["file", "system", *columns, "error"])
    for entry in entries:
        figures = [entry.get("metrics", {}).get(name) for name in columns]
        known = ["" if figure is None else repr(figure) for figure in figures]
        error = "; ".join(entry.get("error", ()))
        writer.writerow(
            [_plain(entry["file"]), _plain(entry.get("system", "")), *known, _plain(error)]
        )
    return out.getvalue()


def _plain(text: str) -> str:
    """A spreadsheet takes a cell that begins like this for a formula, and would run it."""
    return f"'{text}" if text[:1] in ("=", "+", "-", "@", "\t", "\r") else text


def geojson(flights: Sequence[Flight]) -> str:
    """What each flight sprayed, missed and sprayed twice, and where it flew: RFC 7946, WGS84."""
    features = [feature for flight in flights for feature in _features(flight)]
    return json.dumps({"type": "FeatureCollection", "features": features}, allow_nan=False) + "\n"


def _features(flight: Flight) -> list[dict[str, Any]]:
    mission, log = flight.mission, flight.log
    who = {"file": log.file, "system": log.system}
    found = []
    spoken = not isinstance(flight.metrics.figures["coverage_percent"], Unknown)
    lines = planned_lines(mission) if spoken else []
    if lines:
        ground = areas(lines, flown_lines(log), mission.swath)
        for kind, shape in (
            ("applied", ground.treated),
            ("missed", ground.missed),
            ("applied twice", ground.doubled),
        ):
            found.append(_feature(shape, mission, {**who, "kind": kind, "area_m2": shape.area}))
    track = log.odometry.positions_site
    if len(track) > 1:
        path = shapely.LineString(track[:, :2]).simplify(0.02)
        found.append(_feature(path, mission, {**who, "kind": "flown"}))
    return [one for one in found if one is not None]


def _feature(
    shape: BaseGeometry, mission: Mission, properties: dict[str, Any]
) -> dict[str, Any] | None:
    """None for nothing at all; polygons only of an area, counter-clockwise outside."""
    if properties["kind"] != "flown":
        parts = [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon"]
        shape = shapely.MultiPolygon(parts)
    if shape.is_empty:
        return None

    def placed(points: Points) -> Array:
        level = np.column_stack([points, np.full(len(points), mission.takeoff_ground)])
        return np.round(wgs84_from_site(mission.orchard.origin, level)[:, [1, 0]], DECIMALS)

    on_earth = shapely.transform(shape, placed)
    if on_earth.geom_type == "MultiPolygon":
        on_earth = shapely.orient_polygons(on_earth)
    geometry = json.loads(shapely.to_geojson(on_earth))
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def tum(track: Track) -> str:
    """`time x y z qx qy qz qw` a line: what trajectory tools read; seconds, metres, site frame."""
    rows = np.column_stack(
        [track.times, track.positions_site, track.site_from_body[:, [1, 2, 3, 0]]]
    )
    return "".join(
        f"{row[0]:.6f} " + " ".join(f"{value:.9g}" for value in row[1:]) + "\n"
        for row in rows.tolist()
    )
