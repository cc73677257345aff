"""A survey file becomes an orchard and the crew's wishes for its flight."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.input_text import decoded, parse_toml, read_bounded
from orchard_cli.model.site import Orchard, SiteOrigin
from orchard_cli.model.wishes import FlightWishes

from . import geojson, kml, positions, sheet, tables
from .drawn import Recognised, tables_of
from .features import Drawing
from .given import Given, checked
from .reading import Table
from .rows import TapedRow, crossings, lay_out, tree_rows

LARGEST = 1_000_000  # bytes; a thousand rows of a hundred trees are half of it
LARGEST_DRAWING = 8_000_000  # bytes; a tree takes about 100 in GeoJSON, 200 in KML
_MOST_FAULTS = 50  # listed


class Form(Enum):
    """What a survey's file is, by its ending."""

    TOML = ".toml"
    SHEET = ".csv"
    GEOJSON = ".geojson"
    KML = ".kml"
    KMZ = ".kmz"


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """What a survey file says."""

    file: str  # its name
    sha256: str  # of its bytes
    orchard: Orchard
    wishes: FlightWishes
    tables: Mapping[str, Any]  # the same as survey TOML says it
    recognised: Recognised | None = None  # when it was drawn
    remarks: tuple[str, ...] = ()  # what the crew should know of the terrain


def form_of(path: Path) -> Form:
    """By the file's ending; TOML for one that is not known."""
    ending = path.suffix.lower()
    ending = {".json": ".geojson", ".tsv": ".csv", ".txt": ".csv"}.get(ending, ending)
    return next((form for form in Form if form.value == ending), Form.TOML)


def load(path: Path, given: Given | None = None, flight: Mapping[str, Any] | None = None) -> Survey:
    """Read a survey, whatever its form. Raises InputError with every fault.

    `flight` holds keys of [flight] that shall be other than the file says.
    """
    form = form_of(path)
    largest = LARGEST if form is Form.TOML else LARGEST_DRAWING
    data = read_bounded(path, largest, "split the survey: one file a flight")
    return parse(data, path.name, form, given or Given(), flight)


def parse(
    data: bytes,
    file: str,
    form: Form = Form.TOML,
    given: Given | None = None,
    flight: Mapping[str, Any] | None = None,
) -> Survey:
    """A survey from a file's bytes; `file` names it. Raises InputError with every fault."""
    given = given or Given()
    faults: list[Fault] = []
    said, taped, recognised = _said(data, file, form, given, faults)
    if flight and isinstance(said.get("flight", {}), dict):
        said = {**said, "flight": {**said.get("flight", {}), **flight}}
    top = Table(said, file, faults)
    name = top.text("name", file.partition(".")[0] or file)
    csv = form is Form.SHEET
    site = tables.read_site(top.table("site", _mend("site", "latitude_deg = 23.45", csv)))
    flown = top.table("flight", _mend("flight", "height_m = 3.5", csv))
    tank = tables.read_tank(top.table("tank")) if "tank" in top else None
    wishes = tables.read_wishes(flown, top.table("vehicle"), tank)
    if taped is None:
        taped = tables.read_rows(top.tables("row", tables.MOST_ROWS))
    obstacles = tables.read_obstacles(top.tables("obstacle", 10_000))
    fence = [tables.read_ring(top.table("fence"))] if "fence" in top else []
    keep_outs = [tables.read_ring(t) for t in top.tables("keep_out", 1_000)]
    top.done()
    laid = lay_out(taped)
    faults += crossings(taped, laid)
    if not taped and not faults:
        faults.append(Fault(f"{file}: row", "there is none", "add each row of trees"))
    if faults:
        raise InputError(_shortened(faults, file))
    orchard = Orchard(
        name=name,
        origin=site,
        rows=tree_rows(taped, laid),
        obstacles=tuple(obstacles),
        keep_outs_site=tuple(keep_outs),
        fence_site=fence[0] if fence else np.empty((0, 2)),
    )
    if "row" not in said:
        said = {**said, "row": sheet.tables_of(taped)}
    said = {"name": name, **said}
    return Survey(file, hashlib.sha256(data).hexdigest(), orchard, wishes, said, recognised)


_Said = tuple[dict[str, Any], list[TapedRow] | None, Recognised | None]


def _said(data: bytes, file: str, form: Form, given: Given, faults: list[Fault]) -> _Said:
    """The tables that a file says; a taped sheet's rows beside them, a drawing's recognition."""
    match form:
        case Form.TOML:
            _refuse_given(given, file)
            text = _text(data, file)
            _refuse_many_rows(text, file)
            return parse_toml(text, file), None, None
        case Form.SHEET:
            return _said_by_sheet(_text(data, file), file, given, faults)
        case Form.GEOJSON:
            drawing = geojson.read(data, file)
        case Form.KML | Form.KMZ:
            unpacked = kml.unpacked(data, file) if form is Form.KMZ else data
            drawing = kml.read(unpacked, file)
    return _said_by_drawing(drawing, given, file)


def _said_by_sheet(text: str, file: str, given: Given, faults: list[Fault]) -> _Said:
    head, lines = sheet.split(text, file)
    said = parse_toml(head, file)
    columns = positions.columns_of(lines)
    if not columns:
        _refuse_given(given, file)
        if len(text) > LARGEST:
            raise InputError(Fault(file, f"too large, {LARGEST / 1e6:.0f} MB is the most"))
        return said, sheet.read_rows(lines, file, faults), None
    given = replace(given, settings={**said, **given.settings})
    plane = None
    if positions.in_metres(columns):
        plane, given = _plane(given, file, told_ground="ground" in columns)
    return _said_by_drawing(positions.read(lines, file, plane), given, file)


def _plane(given: Given, file: str, told_ground: bool) -> tuple[SiteOrigin, Given]:
    """The frame of a sheet in metres, by its [site], and what remains given.

    The heading is that of x, not of the rows: they are found; and the height is that at 0, 0.
    """
    faults: list[Fault] = []
    top = Table(given.settings, file, faults)
    site = top.table("site", _mend("site", "latitude_deg = 23.45", csv=True))
    plane = tables.read_site(site)
    if faults:
        raise InputError(faults)
    kept: dict[str, Any] = {"height_reference": plane.height_reference.value}
    if not told_ground:
        kept["height_m"] = plane.height
    return plane, replace(given, settings={**given.settings, "site": kept})


def _said_by_drawing(drawing: Drawing, given: Given, file: str) -> _Said:
    faults: list[Fault] = []
    given = checked(given, file, faults)
    if faults:
        raise InputError(faults)
    said, recognised = tables_of(drawing, given)
    return said, None, recognised


def _refuse_given(given: Given, file: str) -> None:
    if given.anything:
        raise InputError(
            Fault(file, "tells its heights and heading itself", "leave those options out")
        )


def _text(data: bytes, file: str) -> str:
    text = decoded(data, file)
    if not text.strip():
        raise InputError(Fault(file, "is empty", "start from missions/lemon-field.survey.toml"))
    return text


def _mend(table: str, key: str, csv: bool) -> str:
    """How to add a missing table, by one of its keys."""
    if not csv:
        return f"write [{table}] and its keys, like {key}"
    return f'write it above the columns: a line "# [{table}]", then its keys, like "# {key}"'


def _refuse_many_rows(text: str, file: str) -> None:
    """Before the costly parse."""
    count = text.count("[[row]]")
    if count > tables.MOST_ROWS:
        raise InputError(
            Fault(file, f"has {count} rows, {tables.MOST_ROWS} are the most", "split the survey")
        )


def _shortened(faults: list[Fault], file: str) -> list[Fault]:
    if len(faults) <= _MOST_FAULTS:
        return faults
    return [*faults[:_MOST_FAULTS], Fault(file, f"{len(faults) - _MOST_FAULTS} more faults")]
