"""`orchard campaign`: many flights, each judged by what really happened."""

from __future__ import annotations

import json as json_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from rich.table import Table

campaign_app = typer.Typer(
    help="Many flights in simulation, judged by the truth.", no_args_is_help=True,
    rich_markup_mode=None,
)  # fmt: skip


@campaign_app.command()
def orchards(
    n: Annotated[int, typer.Option("--n", min=1, max=1_000_000, help="Flights.")] = 40,
    seed: Annotated[int, typer.Option(min=0, help="Of the campaign: it makes every case.")] = 0,
    system: Annotated[str, typer.Option(help="guided, ego, zones, dfa, none, ...")] = "guided",
    camera: Annotated[str, typer.Option(help="Depth mode of the camera.")] = "212x120",
    workers: Annotated[int, typer.Option(min=1, max=256, help="Flights at once.")] = 1,
    dask: Annotated[
        str | None, typer.Option(help="Fly on the Dask cluster of this scheduler address.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the results; an unfinished campaign goes on.")
    ] = None,
    only: Annotated[
        int | None, typer.Option(min=0, help="Fly this case alone, and keep its log.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="One JSON document on stdout.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Fly random orchards: contacts, near misses, completions, with their certainty."""
    from .camera_options import camera_mode
    from .campaigns.flying import fly_one
    from .campaigns.orchards import Campaign, run
    from .systems import maker
    from .wiring import Choices

    maker(Choices(system=system))  # an unknown system is told before anything is flown
    folder = out if out is not None else Path(f"campaign-orchards-{system}-{seed}")
    campaign = Campaign(n, seed, system, camera_mode(camera), folder)
    if only is not None:
        record = fly_one(campaign.task(only, keep=True))
        _tell(record, json, _one)
    else:
        _tell(run(campaign, workers, dask, quiet), json, _overview)
    if not json and not quiet:
        typer.echo(f"results and logs: {folder}", err=True)


@campaign_app.command()
def faults(
    fault: Annotated[str | None, typer.Option(help="Only this fault, by its name.")] = None,
    phase: Annotated[
        str | None, typer.Option(help="take-off, route, avoidance, return or landing.")
    ] = None,
    speed_factor: Annotated[
        float, typer.Option(min=0.5, max=10, help="Where a fault's limits are not in real time.")
    ] = 3.0,
    out: Annotated[
        Path, typer.Option(help="Folder for results and logs; an unfinished campaign goes on.")
    ] = Path("campaign-faults"),
    json: Annotated[bool, typer.Option("--json", help="One JSON document on stdout.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Let each fault strike in each phase, over a real MAVSDK link, and watch from outside.

    One fault in one phase prints a timeline.
    """
    from .campaigns.faults import chosen, document, record, run, timeline
    from .campaigns.observer import observe

    cells = chosen(fault, phase)
    if len(cells) == 1:
        seen = observe(*cells[0], out / "logs", speed_factor)
        found = document([record(*cells[0], seen)])
        if not json:
            _lines(timeline(seen))
    else:
        found = document(run(cells, out, speed_factor, quiet))
    _tell(found, json, _matrix)


def _lines(rows: list[tuple[str, ...]]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table("s", "mode", "m/s", "setpoint's age, s", "nearest thing, m", "place", box=None)
    for row in rows:
        table.add_row(*row)
    Console().print(table)


def _matrix(document: dict[str, Any]) -> Table:
    from rich.markup import escape
    from rich.table import Table

    table = Table("fault", "phase", "", "what shows it", "what the vehicle did", box=None)
    for one in document["cases"]:
        mark = "[green]ok[/]" if one["ok"] else "[bold red]NOT OK[/]"
        shown = (one["fault"], one["phase"], one["evidence"] or "it did not happen", one["outcome"])
        name, where, evidence, outcome = map(escape, shown)
        table.add_row(name, where, mark, evidence, outcome)
    return table


def _tell(document: dict[str, Any], json: bool, shown: Any) -> None:
    if json:
        typer.echo(json_module.dumps(document, allow_nan=False))
        return
    from rich.console import Console

    Console().print(shown(document))


def _one(record: dict[str, Any]) -> Table:
    from rich.table import Table

    table = Table(box=None, show_header=False)
    for key, value in record.items():
        table.add_row(key, json_module.dumps(value))
    return table


def _overview(document: dict[str, Any]) -> Any:
    from rich.console import Group
    from rich.markup import escape
    from rich.table import Table

    counts = Table("", title=f"{document['system']}, seed {document['seed']}", box=None)
    for heading in ("flights", "share", "95 % from", "to"):
        counts.add_column(heading, justify="right")
    for name, label in _SHOWN.items():
        found = document["intervals"][name]
        parts = (f"{100 * found[key]:.1f} %" for key in ("share", "low", "high"))
        counts.add_row(label, f"{found['count']} of {found['of']}", *parts)
    things = Table("thing", "flights", "contacts", "near misses", "completed", box=None)
    for kind, found in document["by_thing"].items():
        things.add_row(kind, *(str(value) for value in found.values()))
    stories = Table("case", "to be looked at", box=None)
    for story in (*document["failures"], *document["early"]):
        stories.add_row(str(story["case"]), escape(story["why"]))
    return Group(counts, things, stories)


_SHOWN = {
    "contacts": "touched something",
    "near_misses": "passed something unexpected under 0.85 m",
    "near_misses_wide": "under 1.5 m",
    "completed": "completed",
    "corners_left_out": "of these, left out a corner",
    "safe_ends": "ended safe elsewhere",
    "unsafe_ends": "ended otherwise",
    "near_people": "moved within 3 m of a person, at any height",
}
