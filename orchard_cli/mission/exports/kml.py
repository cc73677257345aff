"""KML 2.2 for maps and globes.

KML's absolute heights are above mean sea level (EGM96). A site whose height is ellipsoidal is
therefore drawn relative to the ground, each point with the ground below it; `ground_m`, in the
extended data, says how high that is above the ground at take-off.
"""

from __future__ import annotations

import numpy as np
from lxml import etree
from lxml.builder import ElementMaker

from orchard_cli.errors import Fault, InputError
from orchard_cli.geometry.geodesy import wgs84_from_site
from orchard_cli.model.arrays import Array
from orchard_cli.model.mission import Mission
from orchard_cli.model.site import HeightReference

from .course import Course, Loaded
from .xml import KML, parsed, rendered, text

_K = ElementMaker(namespace=KML, nsmap={None: KML})
_NAMES = {"k": KML}
_STYLES = (
    ("row", "ff50af4c", "5"), ("headland", "ff00a5ff", "3"), ("transit", "ffa0a0a0", "2"),
    ("fence", "ff3c3cff", "3"), ("keep-out", "ff0000c8", "3"),
)  # fmt: skip


def write(course: Course, mission: Mission) -> bytes:
    """The text of a KML file."""
    document = _K.Document(_K.name(course.name))
    for style, colour, width in _STYLES:
        line = _K.LineStyle(_K.color(colour), _K.width(width))
        fill = _K.PolyStyle(_K.color("40" + colour[2:]))
        document.append(_K.Style(line, fill, id=style))
    route = _K.Folder(_K.name("route"))
    for k in range(len(course.ways)):
        route.append(_leg(course, k))
    document.append(route)
    ends = _K.Folder(_K.name("ends"))
    ends.append(_point("take-off", course.home_wgs84, course.reference))
    ends.append(_point("landing", course.landing_wgs84, course.reference))
    document.append(ends)
    areas = _K.Folder(_K.name("areas"))
    if len(course.fence_wgs84):
        areas.append(_ring("fence", "fence", course.fence_wgs84))
    for k, keep_out in enumerate(course.keep_outs_wgs84, 1):
        areas.append(_ring(f"keep-out {k}", "keep-out", keep_out))
    document.append(areas)
    document.append(_trees(course, mission))
    return rendered(_K.kml(document))


def _leg(course: Course, k: int) -> etree._Element:
    way = course.ways[k]
    ground = course.heights[k : k + 2] - course.clear[k : k + 2]
    absolute = course.reference is HeightReference.AMSL
    places = np.array(course.places_wgs84[k : k + 2])
    if not absolute:
        places[:, 2] = course.clear[k : k + 2]
    name = f"row {way.row + 1}" if way.row is not None else way.leg.value
    return _K.Placemark(
        _K.name(name),
        _K.styleUrl(f"#{way.leg.value}"),
        _K.ExtendedData(
            _data("order", str(k + 1)),
            _data("leg", way.leg.value),
            _data("spray", "1" if way.sprays else "0"),
            _data("ground_m", " ".join(f"{g:.4f}" for g in ground)),
            _data("height_reference", course.reference.value),
        ),
        _K.LineString(
            _K.altitudeMode("absolute" if absolute else "relativeToGround"),
            _K.coordinates(_coordinates(places)),
        ),
    )


def _data(name: str, value: str) -> etree._Element:
    return _K.Data(_K.value(value), name=name)


def _coordinates(places_wgs84: Array) -> str:
    """Longitude first."""
    return " ".join(
        f"{place[1]:.9f},{place[0]:.9f}" + (f",{place[2]:.4f}" if len(place) > 2 else "")
        for place in places_wgs84
    )


def _point(name: str, place_wgs84: Array, reference: HeightReference) -> etree._Element:
    mark = _K.Placemark(_K.name(name))
    mark.append(
        _K.ExtendedData(
            _data("ground_height_m", f"{place_wgs84[2]:.4f}"),
            _data("height_reference", reference.value),
        )
    )
    mark.append(_K.Point(_K.coordinates(_coordinates(place_wgs84[None, :2]))))
    return mark


def _ring(name: str, style: str, ring_wgs84: Array) -> etree._Element:
    closed = np.concatenate([ring_wgs84, ring_wgs84[:1]])
    outline = _K.LinearRing(_K.coordinates(_coordinates(closed)))
    polygon = _K.Polygon(_K.outerBoundaryIs(outline))
    return _K.Placemark(_K.name(name), _K.styleUrl(f"#{style}"), polygon)


def _trees(course: Course, mission: Mission) -> etree._Element:
    folder = _K.Folder(_K.name("trees"), _K.visibility("0"))
    for number, row in enumerate(mission.orchard.rows, 1):
        at = np.column_stack([row.trunks_site, row.ground])
        for tree, place in enumerate(wgs84_from_site(mission.orchard.origin, at), 1):
            folder.append(_point(f"row {number}, tree {tree}", place, course.reference))
    return folder


def read(data: bytes) -> Loaded:
    """Read an exported KML file. Raises InputError for anything else."""
    root = parsed(data, "kml")
    marks = root.findall(".//k:Placemark", _NAMES)
    named = {mark.findtext("k:name", namespaces=_NAMES): mark for mark in marks}
    legs = [mark for mark in marks if _told(mark, "order")]
    if "take-off" not in named or not legs:
        raise InputError(Fault("kml", "is no exported route"))
    try:
        legs.sort(key=lambda mark: int(_told(mark, "order")))
        home = float(_told(named["take-off"], "ground_height_m"))
        lines = [_line(mark, home) for mark in legs]
        rings = [(name, _corners(mark)) for name, mark in named.items() if _is_area(mark)]
    except ValueError as error:
        raise InputError(Fault("kml", str(error))) from error
    points = np.concatenate([*(line[:1] for line in lines), lines[-1][1:]])
    return Loaded(
        points[:, :2],
        points[:, 2],
        tuple(_told(mark, "spray") == "1" for mark in legs),
        next((ring for name, ring in rings if name == "fence"), np.empty((0, 2))),
        tuple(ring for name, ring in rings if name != "fence"),
    )


def _told(mark: etree._Element, name: str) -> str:
    found = mark.findtext(f"k:ExtendedData/k:Data[@name='{name}']/k:value", namespaces=_NAMES)
    return found or ""


def _line(mark: etree._Element, home: float) -> Array:
    """(2, 3): latitude, longitude, height above take-off."""
    places = _numbers(text(mark, "k:LineString/k:coordinates", _NAMES))[:, [1, 0, 2]]
    if text(mark, "k:LineString/k:altitudeMode", _NAMES) == "absolute":
        places[:, 2] -= home
    else:
        places[:, 2] += [float(g) for g in _told(mark, "ground_m").split()]
    return places


def _numbers(coordinates: str) -> Array:
    return np.array([[float(v) for v in place.split(",")] for place in coordinates.split()])


def _is_area(mark: etree._Element) -> bool:
    return mark.find("k:Polygon", _NAMES) is not None


def _corners(mark: etree._Element) -> Array:
    path = "k:Polygon/k:outerBoundaryIs/k:LinearRing/k:coordinates"
    return _numbers(text(mark, path, _NAMES))[:-1, 1::-1]
