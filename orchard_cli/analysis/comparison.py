"""Flights and published figures side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .figures import Figure, Metrics, Unknown
from .paper import Published


@dataclass(frozen=True, slots=True)
class Cell:
    """One figure in the comparison."""

    figure: Figure | None  # None: this column does not speak of it
    delta: float | None  # share by which it exceeds the reference; None: no reference


@dataclass(frozen=True, slots=True)
class Row:
    """One metric over all columns: the flights, then the published ones."""

    metric: str
    cells: tuple[Cell, ...]


def comparison(flights: Sequence[Metrics], published: Sequence[Published]) -> tuple[Row, ...]:
    """All metrics but the latencies; the first published column is the flights' reference."""
    names = dict.fromkeys(
        name for flight in flights for name in flight.figures if not name.startswith("latency_")
    )
    reference = published[0].figures if published else {}
    rows = []
    for name in names:
        own = [_cell(flight.figures.get(name), reference.get(name)) for flight in flights]
        papers = [Cell(paper.figures.get(name), None) for paper in published]
        rows.append(Row(name, (*own, *papers)))
    return tuple(rows)


@dataclass(frozen=True, slots=True)
class Delta:
    """How one figure differs from another."""

    absolute: float  # other - first, in the metric's unit
    share: float | None  # of the first's size; None: the first is 0


def delta(first: Figure | None, other: Figure | None) -> Delta | None:
    """What `other` has more than `first`; None when either is not known."""
    if first is None or other is None or isinstance(first, Unknown) or isinstance(other, Unknown):
        return None
    return Delta(other - first, (other - first) / abs(first) if first else None)


def latencies(flight: Metrics) -> dict[str, tuple[float, float, float]]:
    """Median, 99th percentile and maximum in ms of each stage that the flight logged."""
    found = {}
    for name in flight.figures:
        if name.startswith("latency_") and name.endswith("_median_ms"):
            stage = name.removeprefix("latency_").removesuffix("_median_ms")
            figures = [flight.figures[f"latency_{stage}_{kind}_ms"] for kind in _KINDS]
            median, p99, most = (float("nan") if isinstance(f, Unknown) else f for f in figures)
            found[stage] = (median, p99, most)
    return found


_KINDS = ("median", "p99", "max")


def _cell(figure: Figure | None, reference: float | None) -> Cell:
    if reference is None or figure is None or isinstance(figure, Unknown):
        return Cell(figure, None)
    return Cell(figure, figure / reference - 1.0)
