"""`orchard analyze LOG...`: metrics of flights, side by side and beside the papers' figures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchard_cli.errors import Fault, InputError

if TYPE_CHECKING:
    from orchard_cli.analysis import Flight
    from orchard_cli.analysis.paper import Published


def analyze(
    logs: Annotated[list[Path], typer.Argument(help="Logs (.mcap, PX4 .ulg), or folders.")],
    json: Annotated[bool, typer.Option("--json", help="One JSON document on stdout.")] = False,
    html: Annotated[
        Path | None, typer.Option(help="Write one page that works offline to this file.")
    ] = None,
    compare: Annotated[
        bool, typer.Option("--compare", help="Differences to the first log, place by place.")
    ] = False,
    picture: Annotated[
        Path | None, typer.Option(help="Draw the flights to this .png, .svg or .pdf.")
    ] = None,
    paper: Annotated[
        str, typer.Option(help="Published figures beside: liu2024-table1, -table2, none or auto.")
    ] = "auto",
    mission: Annotated[
        Path | None, typer.Option(help="The planned route, for logs of PX4 and ROS 2.")
    ] = None,
    topic: Annotated[
        str | None, typer.Option(help="Odometry or pose topic of a ROS 2 bag; default: the only.")
    ] = None,
    frame: Annotated[
        str, typer.Option(help="Frame of a ROS 2 bag: site, or enu about the site's origin.")
    ] = "site",
    csv: Annotated[Path | None, typer.Option(help="Write a table of all metrics (.csv).")] = None,
    geojson: Annotated[
        Path | None, typer.Option(help="Write the as-applied map, WGS84 (.geojson).")
    ] = None,
    tum: Annotated[
        Path | None, typer.Option(help="Write the flown path for trajectory tools (.tum, .txt).")
    ] = None,
    ndjson: Annotated[
        bool, typer.Option("--ndjson", help="One JSON document a line, a line a log.")
    ] = False,
    workers: Annotated[int, typer.Option(min=1, max=256, help="Logs measured at once.")] = 1,
    dask: Annotated[
        str | None, typer.Option(help="Measure on the Dask cluster of this scheduler address.")
    ] = None,
) -> None:
    """Measure flights from their logs, and compare them."""
    from .analyze_batch import expand
    from .analyze_logs import Ways
    from .analyze_write import Outputs, write_entries, write_flights

    if frame not in ("site", "enu"):
        raise InputError(Fault("--frame", f"no frame {frame!r}", "use site or enu"))
    ways = Ways(html is not None, mission, topic, frame == "enu")
    out = Outputs(json, ndjson, compare, html, picture, csv, geojson, tum)
    found = expand(logs)
    many = workers > 1 or dask is not None or ndjson or any(path.is_dir() for path in logs)
    out.check(len(found), many)
    if many:
        faults = write_entries(found, ways, workers, dask, out)
    else:
        faults = write_flights([path for path, _ in found], ways, paper, out)
    if faults:
        raise InputError(faults)


def published(paper: str, flights: Sequence[Flight]) -> tuple[Published, ...]:
    """The reference columns. Raises InputError for a paper that is not there."""
    from orchard_cli.analysis.paper import FLOWN_IN, PUBLISHED

    if paper == "auto":
        fitting = {FLOWN_IN.get(flight.mission.orchard.name, "none") for flight in flights}
        paper = fitting.pop() if len(fitting) == 1 else "none"
    if paper == "none":
        return ()
    if paper not in PUBLISHED:
        known = ", ".join((*PUBLISHED, "none", "auto"))
        raise InputError(Fault("--paper", f"no figures named {paper!r}", f"use one of {known}"))
    return PUBLISHED[paper]


def draw(path: Path, flights: Sequence[Flight]) -> None:
    """The overview picture of all flights over the first one's orchard."""
    from orchard_cli.analysis.overview import save
    from orchard_cli.simulator.world_file import from_orchard

    first = flights[0]
    world = first.world if first.world is not None else from_orchard(first.mission.orchard)
    save(path, first.mission, flights, world.poles)
