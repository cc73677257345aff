"""Surveys as a spreadsheet: one line a tree, in the order in which the crew walks them.

    # [site]
    # latitude_deg = 23.45
    # longitude_deg = 113.2
    # height_m = 20.0
    # heading_deg = 90.0
    # [flight]
    # height_m = 3.5
    row,distance_m,start_m,gap_m,tree_height_m
    1,,,,2.3
    1,,,3.0,2.2
    2,6.0,0.5,,2.3
    2,,,3.1,2.4

Lines that begin with # are the head, with the same tables as a TOML survey (tables.py); it may have
been through a spreadsheet, which pads and quotes it. Columns, in small or capital letters:
`row` counts from 1; `distance_m` (with `far_distance_m`) and `start_m` stand in a row's first
line; `gap_m` is the distance from the tree before in the same row, empty in a row's first line;
`tree_height_m` and, optionally, `ground_m` stand in each line. Cells are parted by commas,
semicolons or tabs, whichever the line of the columns has most of.
"""

from __future__ import annotations

import csv
import math
import re
from typing import Any

from orchard_cli.errors import Fault, InputError

from .reading import Table
from .rows import TapedRow
from .tables import MOST_ROWS, MOST_TREES, read_distances, read_start

LONGEST = 10_000  # characters in a line
Line = tuple[int, list[str]]
_QUOTED = re.compile(r'"[^"]*"')
_NEEDED = ("row", "gap_m", "tree_height_m")


def split(text: str, file: str) -> tuple[str, list[Line]]:
    """The head, as TOML, and the lines of the sheet with their numbers in the file.

    Raises InputError for a line that cannot be a tree's.
    """
    lines = text.splitlines()
    body = [(n, line) for n, line in enumerate(lines, 1) if _is_body(line)]
    if long := [n for n, line in body if len(line) > LONGEST]:
        raise InputError(Fault(f"{file}: line {long[0]}", "is too long for a line of one tree"))
    delimiter = max(",;\t", key=body[0][1].count) if body else ","
    return _head(lines, delimiter), [(n, _cells(line, delimiter)) for n, line in body]


def _is_head(line: str) -> bool:
    return line.lstrip().startswith(("#", '"#'))


def _is_body(line: str) -> bool:
    """Not of the head, and not an empty line of a spreadsheet, which is all separators."""
    return not _is_head(line) and bool(line.strip(" \t,;"))


def _head(lines: list[str], delimiter: str) -> str:
    """The TOML of the head, on its lines of the file.

    Spreadsheets put a line of the head in quotes, and pad it with separators to as many cells as
    there are columns. A list that goes on in the next line keeps one of them: its own comma.
    """
    head, depth = [], 0
    for line in lines:
        if not _is_head(line):
            head.append("")
            continue
        written = _whole(line.strip(), delimiter)[1:]
        bare = written.rstrip(f" \t{delimiter}")
        unquoted = _QUOTED.sub("", bare)
        depth += unquoted.count("[") - unquoted.count("]")
        goes_on = depth > 0 and delimiter == "," and written.rstrip() != bare
        head.append(bare + "," if goes_on else bare)
    return "\n".join(head)


def _whole(line: str, delimiter: str) -> str:
    """A line of the head without the quotes that a spreadsheet put around it."""
    if not line.startswith('"') or len(line) > LONGEST:
        return line
    return delimiter.join(next(csv.reader([line], delimiter=delimiter)))


def _cells(line: str, delimiter: str) -> list[str]:
    """The cells of a line; sheets that part cells with ; or tabs may write decimals with commas."""
    cells = [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))]
    return cells if delimiter == "," else [cell.replace(",", ".") for cell in cells]


def read_rows(lines: list[Line], file: str, faults: list[Fault]) -> list[TapedRow]:
    """The rows of a sheet; faults are added to `faults`."""
    columns = [name.lower() for name in lines[0][1]] if lines else []
    missing = [name for name in _NEEDED if name not in columns]
    if missing:
        where = f"{file}: line {lines[0][0]}" if lines else f"{file}: row"
        faults.append(
            Fault(
                where,
                f"no column {', '.join(missing)}",
                "begin the sheet with row,distance_m,start_m,gap_m,tree_height_m, or, for "
                "positions, with latitude,longitude or x_m,y_m",
            )
        )
        return []
    rows: list[TapedRow] = []
    for number, cells in lines[1:]:
        table = Table(values(columns, cells), f"{file}: line {number}", faults)
        if len(cells) > len(columns):
            table.fault("", f"has {len(cells)} cells for {len(columns)} columns", "remove some")
        row = table.number("row", 1, MOST_ROWS)
        if math.isfinite(row) and row == len(rows) + 1:
            rows.append(_begun(table, first=not rows))
        elif rows and row == len(rows):
            _continue(table, rows[-1])
        elif math.isfinite(row):
            table.fault("row", f"is {row:g} after row {len(rows)}", "number rows 1, 2, 3, ...")
        table.done()
    for taped in rows:
        if not taped.gaps:
            faults.append(Fault(taped.where, "the row has one tree", "a row needs two"))
    return rows


def _begun(table: Table, first: bool) -> TapedRow:
    """A row from the line of its first tree."""
    distance, far = read_distances(table, first)
    if "gap_m" in table:
        table.fault("gap_m", "stands in a row's first line", "leave it empty there")
    table.number("gap_m", -math.inf, math.inf, 0.0)
    heights, ground = _tree(table)
    start = read_start(table, first)
    return TapedRow(table.where, distance, far, start, [], [heights], [ground])


def _continue(table: Table, row: TapedRow) -> None:
    """Add the tree of a line to its row."""
    for key in ("distance_m", "far_distance_m", "start_m"):
        if key in table:
            table.fault(key, "stands after a row's first line", "leave it empty there")
        table.number(key, -math.inf, math.inf, 0.0)
    height, ground = _tree(table)
    lists: tuple[Any, Any, Any] = (row.gaps, row.heights, row.ground)
    if len(row.heights) == MOST_TREES:
        table.fault("row", f"has more than {MOST_TREES} trees", "split the survey")
    if len(row.heights) <= MOST_TREES:
        for values, value in zip(
            lists, (table.number("gap_m", 0.1, 200), height, ground), strict=True
        ):
            values.append(value)


def tables_of(rows: list[TapedRow]) -> list[dict[str, Any]]:
    """The rows as [[row]] tables say them."""
    return [
        {
            **({"distance_m": row.distance} if k else {}),
            **({"far_distance_m": row.far_distance} if row.far_distance != row.distance else {}),
            **({"start_m": row.start} if k else {}),
            "gaps_m": list(row.gaps),
            "tree_height_m": list(row.heights),
            **({"ground_m": list(row.ground)} if any(row.ground) else {}),
        }
        for k, row in enumerate(rows)
    ]


def _tree(table: Table) -> tuple[float, float]:
    return table.number("tree_height_m", 0.2, 60), table.number("ground_m", -500, 500, 0.0)


def values(columns: list[str], cells: list[str]) -> dict[str, Any]:
    """Cells by column, empty ones left out, numbers as numbers."""
    found: dict[str, Any] = {}
    for name, cell in zip(columns, cells, strict=False):
        if cell:
            try:
                found[name] = float(cell)
            except ValueError:
                found[name] = cell
    return found
