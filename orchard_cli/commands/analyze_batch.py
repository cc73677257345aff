"""Many logs at once: in processes of this machine or on a Dask cluster, each fault kept."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orchard_cli.errors import Fault, InputError

from .analyze_logs import Faults, Ways, measured
from .pool import spread

if TYPE_CHECKING:
    from rich.table import Table

SUFFIXES = (".mcap", ".ulg")


@dataclass(frozen=True, slots=True)
class Entry:
    """One log of many: its entry in the JSON document, or why it has none."""

    number: int  # in the order asked for
    document: dict[str, Any]
    faults: Faults = ()


@dataclass(frozen=True, slots=True)
class Task:
    """What a worker is handed; small, so that it travels to other machines."""

    number: int
    path: Path
    name: str  # as shown: below the folder that was named
    ways: Ways


def expand(paths: Sequence[Path]) -> list[tuple[Path, str]]:
    """Logs with their names; a folder gives all that are in it, sorted. Raises InputError."""
    found: list[tuple[Path, str]] = []
    for path in paths:
        if not path.is_dir():
            found.append((path, path.name))
            continue
        inside = sorted(one for one in path.rglob("*") if one.suffix.lower() in SUFFIXES)
        if not inside:
            what = f"holds no log ({' or '.join(SUFFIXES)})"
            raise InputError(Fault(str(path), what, "name a folder with logs"))
        found += [(one, str(one.relative_to(path))) for one in inside]
    return found


def measure_one(task: Task) -> Entry:
    """Measure one log. Never raises: one log that cannot be measured does not end the others."""
    from .analyze_document import entry, failure

    try:
        return Entry(task.number, {**entry(measured(task.path, task.ways)), "file": task.name})
    except InputError as error:
        faults = error.faults
    except Exception as error:
        what = f"could not be measured: {type(error).__name__}: {error}"
        faults = (Fault(str(task.path), what, "please report it"),)
    return Entry(task.number, {**failure(task.path, faults), "file": task.name}, faults)


def measure_all(
    logs: Sequence[tuple[Path, str]], ways: Ways, workers: int, dask: str | None
) -> list[Entry]:
    """Every log's entry, in the order asked for, whoever measured it; a bar on stderr meanwhile."""
    tasks = [Task(n, path.absolute(), name, ways) for n, (path, name) in enumerate(logs)]
    found = spread(measure_one, tasks, workers, dask, "measuring")
    return sorted(found, key=lambda one: one.number)


def lines(entries: Sequence[Entry]) -> str:
    """NDJSON: one document a line."""
    return "".join(json.dumps(one.document, allow_nan=False) + "\n" for one in entries)


def overview(entries: Sequence[Entry]) -> Table:
    """One line a log: what is looked for first."""
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    table.add_column("log", overflow="fold")
    for head in ("system", "distance\n(m)", "time\n(s)", "deviation\nmax (m)", "clearance\n(m)"):
        table.add_column(head, justify="right", no_wrap=True)
    table.add_column("verdicts")
    for one in entries:
        if one.faults:
            table.add_row(escape(one.document["file"]), *[""] * 5, "[red]not measured[/]")
            continue
        figures = one.document["metrics"]
        shown = [_number(figures[name]) for name in (
            "distance_m", "duration_s", "deviation_max_m", "clearance_min_m")]  # fmt: skip
        name, system = escape(one.document["file"]), escape(one.document["system"])
        table.add_row(name, system, *shown, _verdict(one))
    return table


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


def _verdict(one: Entry) -> str:
    broken = [verdict["metric"] for verdict in one.document["verdicts"] if verdict["kept"] is False]
    return f"[bold red]BROKEN[/] {', '.join(broken)}" if broken else "kept"
