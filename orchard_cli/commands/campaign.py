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
    "safe_ends": "ended safe elsewhere",
    "unsafe_ends": "ended otherwise",
    "near_people": "moved within 3 m of a person, at any height",
}
