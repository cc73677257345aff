"""The tables of `orchard analyze` for people."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from orchard_cli.analysis import Unknown
from orchard_cli.analysis.comparison import Cell, comparison, latencies
from orchard_cli.analysis.paper import Published

from .analyze import Analyzed, names


def show(results: Sequence[Analyzed], published: Sequence[Published]) -> None:
    """Metrics side by side, then each flight's verdicts, latencies and notes, on stdout."""
    console = Console()
    console.print(_metrics(results, published))
    for name, result in zip(names(results), results, strict=True):
        console.print(_verdicts(name, result))
        if latencies(result.metrics):
            console.print(_latencies(name, result))
        _notes(console, name, result)
    for paper in published:
        for note in (f"{paper.name}: {paper.source}", *paper.notes):
            console.print(f"  {note}", style="dim", highlight=False)


def _metrics(results: Sequence[Analyzed], published: Sequence[Published]) -> Table:
    table = Table(title="Metrics", title_justify="left", box=None, pad_edge=False)
    table.add_column("metric", no_wrap=True)
    for column in (*names(results), *(paper.name for paper in published)):
        table.add_column(column, justify="right")
    for row in comparison([result.metrics for result in results], published):
        table.add_row(row.metric, *(_text(cell) for cell in row.cells))
    return table


def _text(cell: Cell) -> str:
    if cell.figure is None:
        return ""
    if isinstance(cell.figure, Unknown):
        return "–"
    text = f"{cell.figure}" if isinstance(cell.figure, int) else f"{cell.figure:.3f}"
    return text if cell.delta is None else f"{text} ({cell.delta:+.1%})"


def _verdicts(name: str, result: Analyzed) -> Table:
    table = Table(title=f"Verdicts: {name}", title_justify="left", box=None, pad_edge=False)
    for column in ("", "rule"):
        table.add_column(column)
    for column in ("limit", "found"):
        table.add_column(column, justify="right")
    words = {True: "[green]kept[/]", False: "[bold red]BROKEN[/]", None: "[yellow]unknown[/]"}
    for one in result.verdicts:
        found = "–" if isinstance(one.found, Unknown) else f"{one.found:.3f}"
        rule = f"{one.rule} ({one.metric})"
        table.add_row(words[one.kept], rule, f"{one.limit:.3f}", found)
    return table


def _latencies(name: str, result: Analyzed) -> Table:
    table = Table(title=f"Onboard cycle: {name}", title_justify="left", box=None, pad_edge=False)
    table.add_column("stage")
    for column in ("median ms", "p99 ms", "max ms"):
        table.add_column(column, justify="right")
    for stage, times in latencies(result.metrics).items():
        table.add_row(stage, *(f"{time:.2f}" for time in times))
    return table


def _notes(console: Console, name: str, result: Analyzed) -> None:
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
