"""Missions for other tools, and pictures of them.

Whatever is written for a machine is read back before it is handed out: the geometry has to agree
to a centimetre and the pump leg by leg.
"""

from __future__ import annotations

from enum import Enum

from orchard_cli.errors import Fault, InputError, OrchardError
from orchard_cli.model.mission import Mission

from . import geojson, kml, page, plan, png, svg, table, wpl, wpml
from .course import Course, Loaded, course, differences
from .items import Pump, PumpBy
from .sketch import plan_view

__all__ = ["Format", "Pump", "PumpBy", "course", "differences", "export", "is_own", "read"]


class Format(Enum):
    """What a mission can be written as, by the name that the command line takes."""

    PLAN = "plan"
    WPL = "wpl"
    KML = "kml"
    GEOJSON = "geojson"
    CSV = "csv"
    WPML = "wpml"
    SVG = "svg"
    PNG = "png"
    HTML = "html"

    @property
    def is_picture(self) -> bool:
        """Made for the eye: it cannot be read back, and it shows several missions at once."""
        return self in (Format.SVG, Format.PNG, Format.HTML)


_READERS = {
    Format.PLAN: plan.read,
    Format.WPL: wpl.read,
    Format.KML: kml.read,
    Format.GEOJSON: geojson.read,
    Format.CSV: table.read,
    Format.WPML: wpml.read,
}


def export(missions: list[Mission], form: Format, pump: Pump | None = None) -> bytes:
    """The bytes of a file about one mission, or of a picture of one or more of one orchard.

    Raises InputError where there are several missions for a format that holds one.
    """
    if form.is_picture:
        if form is Format.HTML:
            return page.write(missions)
        title = missions[0].name
        draw = svg.write if form is Format.SVG else png.write
        return draw(plan_view(missions), title)
    if len(missions) != 1:
        raise InputError(
            Fault(f"--format {form.value}", "holds one mission", "export them one by one")
        )
    way = course(missions[0])
    data = _written(way, missions[0], form, pump or Pump())
    if faults := differences(way, read(data, form)):
        raise OrchardError(
            f"the {form.value} file, read back, is not the mission: "
            + "; ".join(str(fault) for fault in faults)
        )
    return data


def _written(way: Course, mission: Mission, form: Format, pump: Pump) -> bytes:
    if form is Format.PLAN:
        return plan.write(way, pump)
    if form is Format.WPL:
        return wpl.write(way, pump)
    if form is Format.KML:
        return kml.write(way, mission)
    if form is Format.GEOJSON:
        return geojson.write(way, mission)
    if form is Format.CSV:
        return table.write(way)
    return wpml.write(way)


def read(data: bytes, form: Format) -> Loaded:
    """What an exported file says. Raises InputError where it is not of that format."""
    return _READERS[form](data)


def is_own(data: bytes, form: Format) -> bool:
    """Whether these bytes were exported before, and so may be written over."""
    if form.is_picture:
        return svg.MARK.encode() in data
    try:
        read(data, form)
    except (InputError, ValueError):
        return False
    return True
