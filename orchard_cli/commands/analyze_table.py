"""The tables of `orchard analyze` for people."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from orchard_cli.analysis import Flight, Unknown, names
from orchard_cli.analysis.aligned import met
from orchard_cli.analysis.comparison import Cell, Delta, comparison, delta, latencies
from orchard_cli.analysis.paper import Published


def show(results: Sequence[Flight], published: Sequence[Published], compare: bool = False) -> None:
    """Metrics side by side, then each flight's verdicts, latencies and notes, on stdout.

    `compare`: with the differences to the first flight, and avoidances by place, and no more.
    """
    console = Console()
    for table in _metrics(results, published, console.width, compare):
        console.print(table)
    if len(results) > 1:
        for name, result in zip(names(results), results, strict=True):
            console.print(f"  {name}: {result.log.file}", highlight=False, soft_wrap=True)
    if compare:
        for table in _met(results, console.width):
            console.print(table)
        return
    for name, result in zip(names(results), results, strict=True):
        console.print(_verdicts(name, result))
        if latencies(result.metrics):
            console.print(_latencies(name, result))
        _notes(console, name, result)
    for paper in published:
        for note in (f"{paper.name}: {paper.source}", *paper.notes):
            console.print(f"  {note}", style="dim", highlight=False)


def _metrics(
    results: Sequence[Flight], published: Sequence[Published], width: int, compare: bool
) -> list[Table]:
    """All columns in as many tables, one below the other, as the width asks for."""
    rows = comparison([result.metrics for result in results], () if compare else published)
    columns = [["metric", *(row.metric for row in rows)]]
    called = names(results)
    for i, name in enumerate(called):
        columns.append([name, *(_text(row.cells[i]) for row in rows)])
        if compare and i:
            head = f"{name} - {called[0]}"
            deltas = [delta(row.cells[0].figure, row.cells[i].figure) for row in rows]
            columns.append([head, *map(_change, deltas)])
    for paper in published:
        figures = [paper.figures.get(row.metric) for row in rows]
        columns.append([paper.name, *(_text(Cell(figure, None)) for figure in figures)])
    return _beside("Metrics", columns, width)


def _met(results: Sequence[Flight], width: int) -> list[Table]:
    """What each flight did where it met an obstacle: deviation and clearance, by place."""
    rows = met(results)
    columns = [["place_m", *(f"{row.place_m:.0f}" for row in rows)]]
    for i, name in enumerate(names(results)):
        ones = [row.avoidances[i] for row in rows]
        columns.append([f"{name} peak_m", *("-" if a is None else f"{a.peak_m:.3f}" for a in ones)])
        near = [None if a is None else a.clearance_min_m for a in ones]
        columns.append([f"{name} clearance_m", *(_text(Cell(figure, None)) for figure in near)])
    return _beside("Avoidances along the route", columns, width) if rows else []


def _beside(title: str, columns: Sequence[list[str]], width: int) -> list[Table]:
    """The first column and as many others as fit, then the next ones below."""
    groups: list[list[list[str]]] = [[columns[0]]]
    for column in columns[1:]:
        if len(groups[-1]) > 1 and _wide([*groups[-1], column]) > width:
            groups.append([columns[0]])
        groups[-1].append(column)
    return [_side_by_side(title, group) for group in groups]


def _change(change: Delta | None) -> str:
    if change is None:
        return ""
    return f"{change.absolute:+.3f}" + ("" if change.share is None else f" ({change.share:+.1%})")


def _wide(columns: Sequence[Sequence[str]]) -> int:
    """Characters in a line of these columns, two between them."""
    return sum(max(map(len, column)) + 2 for column in columns) - 2


def _side_by_side(title: str, columns: Sequence[Sequence[str]]) -> Table:
    """Columns, each with its head first; a figure and its delta stay in one piece."""
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    for i, (head, *_) in enumerate(columns):
        table.add_column(head, justify="right" if i else "left", no_wrap=True)
    for line in zip(*(cells for _, *cells in columns), strict=True):
        table.add_row(*line)
    return table


def _text(cell: Cell) -> str:
    if cell.figure is None:
        return ""
    if isinstance(cell.figure, Unknown):
        return "–"
    text = _number(cell.figure)
    return text if cell.delta is None else f"{text} ({cell.delta:+.1%})"


def _number(value: float) -> str:
    return f"{value}" if isinstance(value, int) else f"{value:.3f}"


def _verdicts(name: str, result: Flight) -> Table:
    table = Table(title=f"Verdicts: {name}", title_justify="left", box=None, pad_edge=False)
    for column in ("", "rule"):
        table.add_column(column)
    for column in ("limit", "found"):
        table.add_column(column, justify="right")
    words = {True: "[green]kept[/]", False: "[bold red]BROKEN[/]", None: "[yellow]unknown[/]"}
    for one in result.verdicts:
        found = "–" if isinstance(one.found, Unknown) else _number(one.found)
        rule = f"{one.rule} ({one.metric})"
        table.add_row(words[one.kept], rule, _number(one.limit), one.found_text or found)
    return table


def _latencies(name: str, result: Flight) -> Table:
    table = Table(title=f"Onboard cycle: {name}", title_justify="left", box=None, pad_edge=False)
    table.add_column("stage")
    for column in ("median ms", "p99 ms", "max ms"):
        table.add_column(column, justify="right")
    for stage, times in latencies(result.metrics).items():
        table.add_row(stage, *(f"{time:.2f}" for time in times))
    return table


def _notes(console: Console, name: str, result: Flight) -> None:
    figures = result.metrics.figures
    reasons: dict[str, list[str]] = {}
    for metric, figure in figures.items():
        if isinstance(figure, Unknown):
            reasons.setdefault(figure.why, []).append(metric)
    console.print(f"{name} ({result.log.file})", highlight=False)
    for note in result.metrics.notes:
        console.print(f"  {note}", highlight=False)
    for why, metrics in reasons.items():
        console.print(f"  –: {why}: {', '.join(metrics)}", style="dim", highlight=False)
