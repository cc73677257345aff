"""A survey file becomes an orchard and the crew's wishes for its flight."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.input_text import decoded, parse_toml, read_bounded
from orchard_cli.model.site import Orchard
from orchard_cli.model.wishes import FlightWishes

from . import sheet, tables
from .reading import Table
from .rows import crossings, lay_out, tree_rows

LARGEST = 1_000_000  # bytes; a thousand rows of a hundred trees are half of it
_MOST_FAULTS = 50  # listed


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """What a survey file says."""

    file: str  # its name
    sha256: str  # of its bytes
    orchard: Orchard
    wishes: FlightWishes


def load(path: Path) -> Survey:
    """Read a survey, TOML or CSV by the file's ending. Raises InputError with every fault."""
    data = read_bounded(path, LARGEST, "split the survey: one file a flight")
    return parse(data, path.name, csv=path.suffix.lower() == ".csv")


def parse(data: bytes, file: str, csv: bool = False) -> Survey:
    """A survey from a file's bytes; `file` names it. Raises InputError with every fault."""
    text = _text(data, file)
    faults: list[Fault] = []
    if csv:
        head, lines = sheet.split(text, file)
        top = Table(parse_toml(head, file), file, faults)
    else:
        _refuse_many_rows(text, file)
        top = Table(parse_toml(text, file), file, faults)
    name = top.text("name", file.partition(".")[0] or file)
    site = tables.read_site(top.table("site", _mend("site", "latitude_deg = 23.45", csv)))
    flight = top.table("flight", _mend("flight", "height_m = 3.5", csv))
    wishes = tables.read_wishes(flight, top.table("vehicle"))
    taped = (
        sheet.read_rows(lines, file, faults)
        if csv
        else tables.read_rows(top.tables("row", tables.MOST_ROWS))
    )
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
        **({"fence_site": fence[0]} if fence else {}),
    )
    return Survey(file, hashlib.sha256(data).hexdigest(), orchard, wishes)


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
