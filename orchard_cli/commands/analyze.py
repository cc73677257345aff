"""`orchard analyze LOG...`: metrics of flights, side by side and beside the papers' figures."""

from __future__ import annotations

import json as json_module
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchard_cli.errors import Fault, InputError

if TYPE_CHECKING:
    from orchard_cli.analysis import Flight
    from orchard_cli.analysis.paper import Published


def analyze(
    logs: Annotated[
        list[Path], typer.Argument(help="Logs of `orchard fly`, PX4 (.ulg) or ROS 2 (.mcap).")
    ],
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
) -> None:
    """Measure flights from their logs, and compare them."""
    if compare and len(logs) < 2:
        raise InputError(Fault("--compare", "needs two logs or more", "name another log"))
    from .analyze_document import document
    from .analyze_logs import Ways, read_all

    if frame not in ("site", "enu"):
        raise InputError(Fault("--frame", f"no frame {frame!r}", "use site or enu"))
    ways = Ways(html is not None, mission, topic, frame == "enu")
    flights, faults = read_all(logs, ways)
    references = published(paper, flights)
    if json:
        typer.echo(json_module.dumps(document(flights, faults, compare), indent=2, allow_nan=False))
    elif flights:
        from .analyze_table import show

        show(flights, references, compare)
    if picture is not None and flights:
        draw(picture, flights)
    if html is not None and flights:
        from orchard_cli.analysis.page import save

        save(html, flights, references)
    if faults:
        raise InputError([fault for _, found in faults for fault in found])


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
