"""`orchard reproduce PAPER`: the published tables, measured anew."""

from __future__ import annotations

import contextlib
import json as json_module
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from .reproduction.rows import Row


def reproduce(
    paper: Annotated[str, typer.Argument(help="A paper, or all that there are.")],
    table: Annotated[
        str | None, typer.Option(help="Only this table or figure: 4, fig13, ...")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for rows.json, pictures, worlds and logs.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of every flight and trial.")] = 0,
    seeds: Annotated[
        int, typer.Option(min=1, max=1000, help="Flights for each column of liu2024's tables.")
    ] = 5,
    workers: Annotated[int, typer.Option(min=1, max=256, help="Of those, at once.")] = 1,
    reuse: Annotated[
        bool,
        typer.Option("--reuse", help="Measure logs in --out, whatever code or inputs flew them."),
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="One JSON document on stdout.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Measure a paper's tables again: paper | ours | difference.

    With --out a run that was broken off goes on: what was flown with the same inputs and code is
    not flown again.
    """
    from .reproduction.desk import Desk
    from .reproduction.registry import chosen, papers
    from .reproduction.rows import document

    wanted = [(one, chosen(one, table)) for one in papers(paper)]
    rows: list[Row] = []
    with _folder(out) as folder:
        for one, tables in wanted:
            desk = Desk(folder / one.name, seed, reuse, quiet, seeds, workers)
            desk.folder.mkdir(parents=True, exist_ok=True)
            found = [row for measure in tables.values() for row in measure(desk)]
            rows += found
            if not json:
                _show(one.title, found)
        if out is not None:
            text = json_module.dumps(document(rows), indent=2, allow_nan=False)
            (out / "rows.json").write_text(text, encoding="utf-8")
    if json:
        typer.echo(json_module.dumps(document(rows), allow_nan=False))


@contextlib.contextmanager
def _folder(out: Path | None) -> Iterator[Path]:
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        yield out
        return
    with tempfile.TemporaryDirectory(prefix="orchard-reproduce-") as scratch:
        yield Path(scratch)


def _show(title: str, rows: list[Row]) -> None:
    from rich.console import Console
    from rich.table import Table

    from .reproduction.rows import difference

    shown = Table("table", "row", "column", title=title, title_justify="left")
    for heading in ("paper", "ours", "difference"):
        shown.add_column(heading, justify="right")
    shown.add_column("unit")
    shown.add_column("note", overflow="fold")
    for row in rows:
        figures = ["-" if value is None else f"{value:.4g}" for value in (row.paper, row.ours)]
        figures[1] += f" ({row.spread})" if row.spread else ""
        cells = (row.table, row.row, row.column, *figures, difference(row), row.unit, row.note)
        shown.add_row(*cells)
    Console().print(shown)
