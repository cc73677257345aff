"""What `orchard analyze` writes: documents, tables, pictures, pages and exports."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import typer

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.output_file import write_whole

from .analyze_batch import lines, measure_all, overview
from .analyze_logs import Ways, read_all


@dataclass(frozen=True, slots=True)
class Outputs:
    """What was asked for."""

    json: bool
    ndjson: bool
    compare: bool
    html: Path | None
    picture: Path | None
    csv: Path | None
    geojson: Path | None
    tum: Path | None

    def check(self, logs: int, many: bool) -> None:
        """Raises InputError, every fault together, where the choices do not go together."""
        alone = "name the logs one by one, without folders, --workers, --ndjson and --dask"
        wrong = (
            (self.compare and logs < 2, "--compare", "needs two logs or more", "name another log"),
            (self.json and self.ndjson, "--ndjson", "is another form than --json", "choose one"),
            (many and self.compare, "--compare", "is for a few logs", alone),
            (many and self.html is not None, "--html", "is for a few logs", alone),
            (many and self.picture is not None, "--picture", "is for a few logs", alone),
            (many and self.geojson is not None, "--geojson", "is for a few logs", alone),
            (self.tum is not None and (many or logs > 1), "--tum", "is for one log", "name one"),
        )
        faults = [Fault(where, what, mend) for is_so, where, what, mend in wrong if is_so]
        if faults:
            raise InputError(faults)


def write_flights(paths: Sequence[Path], ways: Ways, paper: str, out: Outputs) -> tuple[Fault, ...]:
    """Measure a few logs and write all that was asked for; returns what could not be read."""
    from .analyze import draw, published
    from .analyze_document import document, entry, failure

    flights, faults = read_all(paths, ways)
    references = published(paper, flights)
    if out.json:
        typer.echo(json.dumps(document(flights, faults, out.compare), indent=2, allow_nan=False))
    elif flights:
        from .analyze_table import show

        show(flights, references, out.compare and len(flights) > 1)
    if out.picture is not None and flights:
        draw(out.picture, flights)
    if out.html is not None and flights:
        from orchard_cli.analysis.page import save

        save(out.html, flights, references)
    if out.csv is not None:
        from orchard_cli.analysis.exports import csv_table

        entries = [entry(one) for one in flights] + [failure(*fault) for fault in faults]
        write_whole(out.csv, csv_table(entries), (".csv",))
    if out.geojson is not None and flights:
        from orchard_cli.analysis.exports import geojson

        write_whole(out.geojson, geojson(flights), (".geojson", ".json"))
    if out.tum is not None and flights:
        from orchard_cli.analysis.exports import tum

        write_whole(out.tum, tum(flights[0].log.odometry), (".tum", ".txt"))
    return tuple(fault for _, found in faults for fault in found)


def write_entries(
    logs: Sequence[tuple[Path, str]], ways: Ways, workers: int, dask: str | None, out: Outputs
) -> tuple[Fault, ...]:
    """Measure many logs and write their entries; returns what could not be read."""
    from .analyze_document import SCHEMA

    entries = measure_all(logs, ways, workers, dask)
    documents = [one.document for one in entries]
    if out.json:
        whole = {"schema": SCHEMA, "logs": documents}
        typer.echo(json.dumps(whole, indent=2, allow_nan=False))
    elif out.ndjson:
        typer.echo(lines(entries), nl=False)
    else:
        from rich.console import Console

        Console().print(overview(entries))
    if out.csv is not None:
        from orchard_cli.analysis.exports import csv_table

        write_whole(out.csv, csv_table(documents), (".csv",))
    return tuple(fault for one in entries for fault in one.faults)
