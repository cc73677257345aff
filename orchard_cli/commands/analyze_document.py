"""The JSON document of `orchard analyze`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from orchard_cli.analysis import Flight, Unknown
from orchard_cli.analysis.aligned import met
from orchard_cli.analysis.comparison import delta
from orchard_cli.errors import Fault

SCHEMA = "orchard-analyze/1"


def document(
    flights: Sequence[Flight],
    faults: Sequence[tuple[Path, tuple[Fault, ...]]] = (),
    compare: bool = False,
) -> dict[str, Any]:
    """What is not known is null, and `unknown` says why; `compare` adds the differences."""
    logs = [entry(flight) for flight in flights]
    logs += [failure(path, found) for path, found in faults]
    found: dict[str, Any] = {"schema": SCHEMA, "logs": logs}
    return {**found, "comparison": _comparison(flights)} if compare and flights else found


def _comparison(flights: Sequence[Flight]) -> dict[str, Any]:
    """Differences of every figure to the first flight's, and avoidances by place."""
    first, *others = flights
    return {
        "reference": first.log.file,
        "deltas": [
            {"file": other.log.file, "metrics": _deltas(first, other)} for other in others
        ],
        "avoidances": [
            {"place_m": row.place_m,
             "peak_m": [None if one is None else one.peak_m for one in row.avoidances],
             "clearance_min_m": [None if one is None else _number(one.clearance_min_m)
                                 for one in row.avoidances]}
            for row in met(flights)
        ],
    }  # fmt: skip


def _deltas(first: Flight, other: Flight) -> dict[str, dict[str, float | None] | None]:
    found = {}
    for name, figure in first.metrics.figures.items():
        one = delta(figure, other.metrics.figures.get(name))
        found[name] = None if one is None else {"absolute": one.absolute, "share": one.share}
    return found


def failure(path: Path, faults: Sequence[Fault]) -> dict[str, Any]:
    """The entry of a log that could not be measured."""
    return {"file": path.name, "error": [str(fault) for fault in faults]}


def entry(flight: Flight) -> dict[str, Any]:
    """The entry of one flight."""
    figures = flight.metrics.figures
    return {
        "file": flight.log.file,
        "system": flight.log.system,
        "metrics": {name: _number(figure) for name, figure in figures.items()},
        "unknown": {n: f.why for n, f in figures.items() if isinstance(f, Unknown)},
        "avoidances": [
            {
                "start_s": one.start,
                "end_s": one.end,
                "peak_m": one.peak_m,
                "peak_site_m": [float(v) for v in one.peak_site],
                "altitude_drop_m": one.altitude_drop_m,
                "clearance_min_m": _number(one.clearance_min_m),
            }
            for one in flight.metrics.avoidances
        ],
        "verdicts": [
            {
                "metric": one.metric,
                "rule": one.rule,
                "limit": one.limit,
                "found": _number(one.found),
                "found_text": one.found_text,
                "kept": one.kept,
            }
            for one in flight.verdicts
        ],
        "notes": list(flight.metrics.notes),
    }


def _number(figure: float | Unknown) -> float | None:
    return None if isinstance(figure, Unknown) else figure
