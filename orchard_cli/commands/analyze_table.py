"""The tables of `orchard analyze` for people."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from orchard_cli.analysis import Flight, Unknown, names
from orchard_cli.analysis.comparison import Cell, comparison, latencies
from orchard_cli.analysis.paper import Published


def show(results: Sequence[Flight], published: Sequence[Published]) -> None:
    """Metrics side by side, then each flight's verdicts, latencies and notes, on stdout."""
    console = Console()
    for table in _metrics(results, published, console.width):
        console.print(table)
    if len(results) > 1:
        for name, result in zip(names(results), results, strict=True):
            console.print(f"  {name}: {result.log.file}", highlight=False, soft_wrap=True)
    for name, result in zip(names(results), results, strict=True):
        console.print(_verdicts(name, result))
        if latencies(result.metrics):
            console.print(_latencies(name, result))
        _notes(console, name, result)
    for paper in published:
        for note in (f"{paper.name}: {paper.source}", *paper.notes):
            console.print(f"  {note}", style="dim", highlight=False)


def _metrics(results: Sequence[Flight], published: Sequence[Published], width: int) -> list[Table]:
    """All columns in as many tables, one below the other, as the width asks for."""
    rows = comparison([result.metrics for result in results], published)
    first = ["metric", *(row.metric for row in rows)]
    heads = (*names(results), *(paper.name for paper in published))
    groups: list[list[list[str]]] = [[first]]
    for i, head in enumerate(heads):
        column = [head, *(_text(row.cells[i]) for row in rows)]
        if len(groups[-1]) > 1 and _wide([*groups[-1], column]) > width:
            groups.append([first])
        groups[-1].append(column)
    return [_side_by_side(group) for group in groups]


def _wide(columns: Sequence[Sequence[str]]) -> int:
    """Characters in a line of these columns, two between them."""
    return sum(max(map(len, column)) + 2 for column in columns) - 2


def _side_by_side(columns: Sequence[Sequence[str]]) -> Table:
    """Columns, each with its head first; a figure and its delta stay in one piece."""
    table = Table(title="Metrics", title_justify="left", box=None, pad_edge=False)
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
