"""GeoJSON (RFC 7946): the route leg by leg, trees, obstacles, fence and keep-outs.

RFC 7946 wants heights above the ellipsoid. Where the survey gave them above mean sea level they
stay so, and the member "orchard" says it: no geoid model is at hand.
"""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import shapely

from orchard_cli.errors import Fault, InputError
from orchard_cli.geometry.geodesy import wgs84_from_site
from orchard_cli.model.arrays import Array
from orchard_cli.model.mission import Mission

from .course import Course, Loaded

_DIGITS = 9  # decimals of a degree: a tenth of a millimetre


def write(course: Course, mission: Mission) -> bytes:
    """The text of a feature collection."""
    features = [_leg(course, k) for k in range(len(course.ways))]
    features += [_place("take-off", course.home_wgs84), _place("landing", course.landing_wgs84)]
    features += _trees(mission) + _obstacles(mission)
    for kind, ring in [("fence", course.fence_wgs84)] + [
        ("keep-out", keep_out) for keep_out in course.keep_outs_wgs84
    ]:
        if len(ring):
            features.append(_feature("Polygon", [_closed(ring)], kind=kind))
    document = {
        "type": "FeatureCollection",
        "orchard": {
            "name": course.name,
            "height_reference": course.reference.value,
            "takeoff_ground_m": round(float(course.home_wgs84[2]), 4),
        },
        "features": features,
    }
    return msgspec.json.encode(document) + b"\n"


def _leg(course: Course, k: int) -> dict[str, Any]:
    way = course.ways[k]
    line = [_coordinates(place) for place in course.places_wgs84[k : k + 2]]
    told = {"kind": "leg", "order": k + 1, "leg": way.leg.value, "spray": way.sprays}
    if way.row is not None:
        told["row"] = way.row + 1
    return _feature("LineString", line, **told)


def _feature(shape: str, coordinates: Any, **told: Any) -> dict[str, Any]:
    return {
        "type": "Feature",
        "properties": told,
        "geometry": {"type": shape, "coordinates": coordinates},
    }


def _place(kind: str, place_wgs84: Array) -> dict[str, Any]:
    return _feature("Point", _coordinates(place_wgs84), kind=kind)


def _coordinates(place_wgs84: Array) -> list[float]:
    """Longitude first."""
    latitude, longitude, *height = (float(v) for v in place_wgs84)
    return [round(longitude, _DIGITS), round(latitude, _DIGITS), *(round(h, 4) for h in height)]


def _closed(ring_wgs84: Array) -> list[list[float]]:
    """Counter-clockwise from above, the first corner again at the end."""
    corners = [_coordinates(corner) for corner in ring_wgs84]
    corners.append(corners[0])
    return corners if shapely.LinearRing(corners).is_ccw else corners[::-1]


def _trees(mission: Mission) -> list[dict[str, Any]]:
    features = []
    for number, row in enumerate(mission.orchard.rows, 1):
        at = np.column_stack([row.trunks_site, row.ground])
        for tree, place in enumerate(wgs84_from_site(mission.orchard.origin, at), 1):
            told = {"kind": "tree", "row": number, "tree": tree}
            told["height_m"] = round(float(row.heights[tree - 1]), 3)
            features.append(_feature("Point", _coordinates(place), **told))
    return features


def _obstacles(mission: Mission) -> list[dict[str, Any]]:
    features = []
    for obstacle in mission.orchard.obstacles:
        at = np.array([[*obstacle.position_site, obstacle.top]])
        place = wgs84_from_site(mission.orchard.origin, at)[0]
        told = {"kind": "obstacle", "name": obstacle.name, "radius_m": obstacle.radius}
        features.append(_feature("Point", _coordinates(place), **told))
    return features


class _Geometry(msgspec.Struct):
    type: str
    coordinates: list[Any]


class _Properties(msgspec.Struct):
    kind: str = ""
    order: int = 0
    spray: bool = False


class _Feature(msgspec.Struct):
    properties: _Properties
    geometry: _Geometry


class _Orchard(msgspec.Struct):
    takeoff_ground_m: float


class _Collection(msgspec.Struct):
    orchard: _Orchard
    features: list[_Feature]


def read(data: bytes) -> Loaded:
    """Read an exported collection. Raises InputError for anything else."""
    try:
        collection = msgspec.json.decode(data, type=_Collection)
        legs = sorted(
            (f for f in collection.features if f.properties.kind == "leg"),
            key=lambda feature: feature.properties.order,
        )
        lines = np.array([f.geometry.coordinates for f in legs], dtype=np.float64)
        lines = lines.reshape(-1, 2, 3)
        rings = {
            kind: [
                np.array(f.geometry.coordinates[0], dtype=np.float64)[:-1, 1::-1]
                for f in collection.features
                if f.properties.kind == kind
            ]
            for kind in ("fence", "keep-out")
        }
    except (msgspec.DecodeError, ValueError, IndexError, TypeError, RecursionError) as error:
        raise InputError(Fault("geojson", f"is no exported collection: {error}")) from error
    if not len(lines) or (lines[:-1, 1] != lines[1:, 0]).any():
        raise InputError(Fault("geojson", "its legs do not follow one another"))
    points = np.concatenate([lines[:, 0], lines[-1:, 1]])
    return Loaded(
        points[:, 1::-1],
        points[:, 2] - collection.orchard.takeoff_ground_m,
        tuple(f.properties.spray for f in legs),
        rings["fence"][0] if rings["fence"] else np.empty((0, 2)),
        tuple(rings["keep-out"]),
    )
