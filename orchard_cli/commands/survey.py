"""`orchard survey`: write a survey by questions, show one, convert one to TOML."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchard_cli.errors import Fault, InputError

from . import survey_input as given
from .survey_new import new

if TYPE_CHECKING:
    from orchard_cli.survey import Survey

survey_app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)


@survey_app.callback()
def survey() -> None:
    """Write, show and convert surveys."""


survey_app.command("new")(new)


@survey_app.command("show")
def show(
    file: given.SurveyFile,
    tree_height: given.TreeHeight = None,
    tree_gap: given.TreeGap = None,
    ground_height: given.GroundHeight = None,
    heading: given.Heading = None,
    flight_height: given.FlightHeight = None,
    block: given.Block = None,
    settings: given.Settings = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> None:
    """Show a survey's rows, and how they were recognised."""
    from orchard_cli import survey as surveys

    options = given.given_from(
        tree_height, tree_gap, ground_height, heading, flight_height, block, settings
    )
    read = surveys.load(file, options)
    if as_json:
        json.dump(_document(read), sys.stdout)
        sys.stdout.write("\n")
        return
    from rich.console import Console

    console = Console()
    given.show(read, console)
    for why in _why_not(read):
        console.print(f"not sure: {why}", highlight=False)


@survey_app.command("convert")
def convert(
    file: given.SurveyFile,
    output: Annotated[Path, typer.Argument(help="Survey TOML to write.")],
    tree_height: given.TreeHeight = None,
    tree_gap: given.TreeGap = None,
    ground_height: given.GroundHeight = None,
    heading: given.Heading = None,
    flight_height: given.FlightHeight = None,
    block: given.Block = None,
    settings: given.Settings = None,
    yes: given.Yes = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing.")] = False,
) -> None:
    """Write any survey as survey TOML, which says the same to the last bit."""
    from orchard_cli import survey as surveys

    if output.suffix.lower() != ".toml":
        raise InputError(Fault(str(output), "is no name of a survey TOML", "end it with .toml"))
    options = given.given_from(
        tree_height, tree_gap, ground_height, heading, flight_height, block, settings
    )
    read = surveys.load(file, options)
    given.confirm(read, yes, quiet)
    remarks = (f"From {read.file}.", *(read.recognised.notes if read.recognised else ()))
    surveys.save(surveys.text_of(read.tables, remarks), output)
    if not quiet:
        typer.echo(str(output))


def _why_not(read: Survey) -> tuple[str, ...]:
    found = read.recognised.found if read.recognised else None
    return found.why_not if found else ()


def _document(read: Survey) -> dict[str, Any]:
    recognised = read.recognised
    found = recognised.found if recognised else None
    return {
        "name": read.orchard.name,
        "rows": [
            {
                "trees": len(row.heights),
                "trunks_m": row.trunks_site.tolist(),
                "heights_m": row.heights.tolist(),
            }
            for row in read.orchard.rows
        ],
        "obstacles": len(read.orchard.obstacles),
        "keep_outs": len(read.orchard.keep_outs_site),
        "fence": bool(len(read.orchard.fence_site)),
        "how": recognised.how if recognised else "told",
        "notes": list(recognised.notes) if recognised else [],
        "found": None
        if found is None
        else {
            "spacing_m": round(found.spacing, 3),
            "scatter_m": round(found.scatter, 3),
            "share_in_doubt": round(found.doubt, 4),
            "not_sure": list(found.why_not),
        },
    }
