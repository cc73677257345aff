"""GeoJSON (RFC 7946) -> features. Positions are longitude, latitude, height."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import msgspec

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.arrays import Array

from .features import MOST_FEATURES, Drawing, Feature, Shape, places, properties_of, ring
from .reading import shown

Position = list[float]
_WGS84 = ("crs84", "4326", "4979")


class _Point(msgspec.Struct, tag="Point"):
    coordinates: Position


class _MultiPoint(msgspec.Struct, tag="MultiPoint"):
    coordinates: list[Position]


class _LineString(msgspec.Struct, tag="LineString"):
    coordinates: list[Position]


class _MultiLineString(msgspec.Struct, tag="MultiLineString"):
    coordinates: list[list[Position]]


class _Polygon(msgspec.Struct, tag="Polygon"):
    coordinates: list[list[Position]]


class _MultiPolygon(msgspec.Struct, tag="MultiPolygon"):
    coordinates: list[list[list[Position]]]


class _Collection(msgspec.Struct, tag="GeometryCollection"):
    geometries: list[_Geometry]


_Geometry = (
    _Point | _MultiPoint | _LineString | _MultiLineString | _Polygon | _MultiPolygon | _Collection
)


class _Feature(msgspec.Struct, tag="Feature"):
    geometry: _Geometry | None
    properties: dict[str, Any] | None = None


class _FeatureCollection(msgspec.Struct, tag="FeatureCollection"):
    features: list[_Feature]
    crs: Any = None
    name: Any = None


_Document = (
    _FeatureCollection
    | _Feature
    | _Point
    | _MultiPoint
    | _LineString
    | _MultiLineString
    | _Polygon
    | _MultiPolygon
    | _Collection
)


def read(data: bytes, file: str) -> Drawing:
    """The features of a GeoJSON file. Raises InputError with its faults."""
    document = _parsed(data, file)
    if isinstance(document, _FeatureCollection):
        _refuse_other_grids(document.crs, file)
        members = document.features
        layer = (document.name,) if isinstance(document.name, str) else ()
    else:
        whole = document if isinstance(document, _Feature) else _Feature(document)
        members, layer = [whole], ()
    faults: list[Fault] = []
    features: list[Feature] = []
    for k, member in enumerate(members, 1):
        features += _features(member, f"{file}: feature {k}", layer, faults)
        if len(features) > MOST_FEATURES:
            raise InputError(Fault(file, f"has more than {MOST_FEATURES} features", "split it"))
    if faults:
        raise InputError(faults)
    return Drawing(file, tuple(features))


def _parsed(data: bytes, file: str) -> _Document:
    try:
        text = data.removeprefix(b"\xef\xbb\xbf")
        document: _Document = msgspec.json.decode(text, type=_Document)
        return document
    except msgspec.ValidationError as error:
        place, what = _place_of(str(error))
        raise InputError(Fault(f"{file}{place}", what, "save it as GeoJSON (RFC 7946)")) from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputError(Fault(file, f"is no JSON: {error}", "export it again")) from error
    except RecursionError as error:
        raise InputError(Fault(file, "is nested too deeply", "export it again")) from error


def _place_of(message: str) -> tuple[str, str]:
    """msgspec's 'what - at `$.place`' as place and what."""
    what, _, at = message.partition(" - at `$")
    place = at.rstrip("`").removeprefix(".")
    return (f": {place}" if place else ""), f"is not understood: {what}"


def _refuse_other_grids(crs: Any, file: str) -> None:
    """GeoJSON of 2008 could name another reference system; today it is always WGS84."""
    if crs is None:
        return
    name = crs.get("properties", {}) if isinstance(crs, dict) else {}
    name = name.get("name", "") if isinstance(name, dict) else ""
    if not isinstance(name, str) or not name.lower().endswith(_WGS84):
        raise InputError(
            Fault(f"{file}: crs", f"is {shown(name)}", "export it in WGS84 (EPSG:4326)")
        )


def _features(
    member: _Feature, where: str, layers: tuple[str, ...], faults: list[Fault]
) -> Iterator[Feature]:
    properties = properties_of(member.properties or {})
    name = next((str(properties[k]) for k in ("name", "title", "id") if k in properties), "")
    if name:
        where = f"{where} {shown(name)}"
    layer = next((properties[k] for k in ("layer", "folder") if k in properties), None)
    layers = (*layers, str(layer)) if layer is not None else layers
    if member.geometry is None:
        faults.append(Fault(where, "has no geometry", "draw it again, or remove it"))
        return
    for shape, parts, place in _parts(member.geometry, where, faults):
        yield Feature(place, shape, parts, name, layers, properties)


def _parts(
    geometry: _Geometry, where: str, faults: list[Fault]
) -> Iterator[tuple[Shape, tuple[Array, ...], str]]:
    """Shape, parts and place of each single geometry."""
    match geometry:
        case _Point():
            yield from _single(Shape.POINT, [geometry.coordinates], where, faults)
        case _MultiPoint():
            for k, position in enumerate(geometry.coordinates, 1):
                yield from _single(Shape.POINT, [position], f"{where}: part {k}", faults)
        case _LineString():
            yield from _single(Shape.LINE, geometry.coordinates, where, faults)
        case _MultiLineString():
            for k, line in enumerate(geometry.coordinates, 1):
                yield from _single(Shape.LINE, line, f"{where}: part {k}", faults)
        case _Polygon():
            yield from _polygon(geometry.coordinates, where, faults)
        case _MultiPolygon():
            for k, rings in enumerate(geometry.coordinates, 1):
                yield from _polygon(rings, f"{where}: part {k}", faults)
        case _Collection():
            for k, member in enumerate(geometry.geometries, 1):
                yield from _parts(member, f"{where}: part {k}", faults)


def _single(
    shape: Shape, positions: list[Position], where: str, faults: list[Fault]
) -> Iterator[tuple[Shape, tuple[Array, ...], str]]:
    found = places(where, positions, faults, 1 if shape is Shape.POINT else 2)
    if found is not None:
        yield shape, (found,), where


def _polygon(
    rings: list[list[Position]], where: str, faults: list[Fault]
) -> Iterator[tuple[Shape, tuple[Array, ...], str]]:
    if not rings:
        faults.append(Fault(where, "is a polygon without a ring", "draw it again, or remove it"))
        return
    found = []
    for k, positions in enumerate(rings, 1):
        place = f"{where}: ring {k}" if len(rings) > 1 else where
        found.append(ring(place, places(place, positions, faults, 4), faults))
    whole = tuple(r for r in found if r is not None)
    if len(whole) == len(rings):
        yield Shape.POLYGON, whole, where
