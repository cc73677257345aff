"""KML 2.2 and KMZ -> features. Coordinates are longitude, latitude, height.

The XML is hostile until it is parsed: no entities, no document types, no network, libxml2's own
limits of depth and size, and a KMZ is unpacked up to a bound. Elements that place nothing (styles,
views, times) are passed over; whatever places something and is not understood is refused.
"""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Iterator
from typing import Any

from lxml import etree

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.arrays import Array

from .features import (
    MOST_FEATURES,
    Drawing,
    Feature,
    Shape,
    Value,
    places,
    properties_of,
    ring,
)
from .reading import shown

Element = Any
LARGEST = 16_000_000  # bytes of the KML, unpacked
_SINGLE = {"Point": Shape.POINT, "LineString": Shape.LINE, "LinearRing": Shape.LINE}
_GEOMETRIES = {*_SINGLE, "Polygon", "MultiGeometry"}
_FOLDERS = {"kml", "Document", "Folder"}
_PLACES_NOTHING = {
    "name", "description", "styleUrl", "Style", "StyleMap", "Schema", "ExtendedData", "Metadata",
    "LookAt", "Camera", "visibility", "open", "address", "AddressDetails", "phoneNumber", "Snippet",
    "snippet", "TimeStamp", "TimeSpan", "Region", "author", "link", "balloonVisibility",
    "NetworkLinkControl",
}  # fmt: skip
_OURS = ("http://www.opengis.net/kml", "http://earth.google.com/kml", "http://www.google.com/kml")


def unpacked(data: bytes, file: str) -> bytes:
    """The one KML of a KMZ. Raises InputError for anything else, and for what is too large."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = [n for n in archive.namelist() if n.lower().endswith(".kml")]
            if len(names) != 1:
                what = f"holds {len(names)} KML files" if names else "holds no KML file"
                raise InputError(Fault(file, what, "save one KML file in it"))
            with archive.open(names[0]) as member:
                text = member.read(LARGEST + 1)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError) as error:
        raise InputError(Fault(file, f"is no KMZ: {error}", "save it again")) from error
    except (RuntimeError, NotImplementedError) as error:  # a password, an unknown method
        raise InputError(Fault(file, f"cannot be unpacked: {error}", "save it again")) from error
    if len(text) > LARGEST:
        raise InputError(
            Fault(file, f"unpacks to more than {LARGEST / 1e6:.0f} MB", "split the drawing")
        )
    return text


def read(data: bytes, file: str) -> Drawing:
    """The features of a KML file. Raises InputError with its faults."""
    root = _parsed(data, file)
    if _tag(root) not in {*_FOLDERS, "Placemark"}:
        raise InputError(Fault(file, f"is no KML: it begins with {_tag(root)}", "export it again"))
    reader = _Reader(file)
    reader.walk(root, ())
    if reader.faults:
        raise InputError(reader.faults)
    return Drawing(file, tuple(reader.features))


def _parsed(data: bytes, file: str) -> Element:
    parser = etree.XMLParser(
        resolve_entities=False,
        load_dtd=False,
        no_network=True,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise InputError(Fault(file, "declares a document type", "export it again as plain KML"))
    try:
        root = etree.fromstring(data, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        raise InputError(Fault(file, f"is no XML: {error}", "export it again")) from error
    if root.getroottree().docinfo.doctype:
        raise InputError(Fault(file, "declares a document type", "export it again as plain KML"))
    return root


def _tag(element: Element) -> str:
    return str(etree.QName(element).localname)


def _is_ours(element: Element) -> bool:
    space = etree.QName(element).namespace
    return space is None or space.startswith(_OURS)


def _text(element: Element, tag: str) -> str:
    found = element.find(f"{{*}}{tag}")
    return (found.text or "").strip() if found is not None else ""


class _Reader:
    """Walks the folders and collects features and faults."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.features: list[Feature] = []
        self.faults: list[Fault] = []
        self._count = 0

    def walk(self, folder: Element, layers: tuple[str, ...]) -> None:
        name = _text(folder, "name")
        layers = (*layers, name) if name else layers
        for child in folder:
            tag = _tag(child)
            if tag in _FOLDERS:
                self.walk(child, layers)
            elif tag == "Placemark":
                self._placemark(child, layers)
            else:
                self._pass_over(child, f"{self.file}: folder {shown(name)}" if name else self.file)

    def _pass_over(self, element: Element, where: str) -> None:
        if _tag(element) in _PLACES_NOTHING or not (
            _is_ours(element) or element.find(".//{*}coordinates") is not None
        ):
            return
        line = f"{where}, line {element.sourceline}"
        self.faults.append(
            Fault(line, f"{_tag(element)} is not understood here", "draw it with points, lines or "
                  "polygons, or remove it")
        )  # fmt: skip

    def _placemark(self, placemark: Element, layers: tuple[str, ...]) -> None:
        self._count += 1
        if self._count > MOST_FEATURES:
            raise InputError(
                Fault(self.file, f"has more than {MOST_FEATURES} placemarks", "split it")
            )
        name = _text(placemark, "name")
        where = f"{self.file}: placemark {self._count}" + (f" {shown(name)}" if name else "")
        properties = _properties(placemark)
        found = 0
        for child in placemark:
            if _tag(child) not in _GEOMETRIES:
                self._pass_over(child, where)
                continue
            found += 1
            for shape, parts, place in self._parts(child, where):
                self.features.append(Feature(place, shape, parts, name, layers, properties))
        if not found and not any(f.where.startswith(where) for f in self.faults[-1:]):
            self.faults.append(Fault(where, "has no geometry", "draw it again, or remove it"))

    def _parts(
        self, geometry: Element, where: str
    ) -> Iterator[tuple[Shape, tuple[Array, ...], str]]:
        tag = _tag(geometry)
        if tag == "MultiGeometry":
            for k, child in enumerate(geometry, 1):
                if _tag(child) in _GEOMETRIES:
                    yield from self._parts(child, f"{where}: part {k}")
                else:
                    self._pass_over(child, where)
        elif tag == "Polygon":
            yield from self._polygon(geometry, where)
        else:
            least = 1 if tag == "Point" else 2
            found = self._places(geometry, _absolute(geometry), where, least)
            if found is not None and tag == "Point" and len(found) != 1:
                self.faults.append(Fault(where, f"is a point of {len(found)} positions"))
            elif found is not None:
                yield _SINGLE[tag], (found,), where

    def _polygon(
        self, polygon: Element, where: str
    ) -> Iterator[tuple[Shape, tuple[Array, ...], str]]:
        absolute = _absolute(polygon)
        outer = polygon.findall("{*}outerBoundaryIs/{*}LinearRing")
        inner = polygon.findall("{*}innerBoundaryIs/{*}LinearRing")
        if len(outer) != 1:
            self.faults.append(
                Fault(where, f"is a polygon with {len(outer)} outer rings", "draw it again")
            )
            return
        rings = []
        for k, element in enumerate([*outer, *inner], 1):
            place = f"{where}: ring {k}" if inner else where
            found = self._places(element, absolute, place, 4)
            rings.append(ring(place, found, self.faults))
        whole = tuple(r for r in rings if r is not None)
        if len(whole) == len(rings):
            yield Shape.POLYGON, whole, where

    def _places(self, element: Element, absolute: bool, where: str, least: int) -> Array | None:
        found = element.findall("{*}coordinates")
        if len(found) != 1:
            self.faults.append(Fault(where, f"has {len(found)} lists of coordinates"))
            return None
        positions = []
        for word in "".join(found[0].itertext()).split():
            try:
                positions.append([float(number) for number in word.split(",")])
            except ValueError:
                self.faults.append(
                    Fault(where, f"{shown(word)} is no position", "write longitude,latitude,height")
                )
                return None
        array = places(where, positions, self.faults, least)
        if array is not None and not absolute:
            array[:, 2] = float("nan")
        return array


def _absolute(geometry: Element) -> bool:
    """Heights count only where they are told above the sea; KML's default is on the ground."""
    return _text(geometry, "altitudeMode") == "absolute"


def _properties(placemark: Element) -> dict[str, Value]:
    values: dict[str, object] = {}
    for data in placemark.iterfind("{*}ExtendedData/{*}Data"):
        values[data.get("name") or ""] = _text(data, "value")
    for data in placemark.iterfind("{*}ExtendedData/{*}SchemaData/{*}SimpleData"):
        values[data.get("name") or ""] = (data.text or "").strip()
    return properties_of(values)
