"""`orchard plan`: survey file -> mission file."""

from __future__ import annotations

import json
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchard_cli import __version__
from orchard_cli.errors import Fault, InputError

from . import survey_input
from .export import chosen_format, write_export

if TYPE_CHECKING:
    from orchard_cli.model.mission import Mission


def plan(
    survey: survey_input.SurveyFile,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="Mission file. Default: beside the survey."),
    ] = None,
    exports: Annotated[
        list[Path] | None,
        typer.Option("--export", help="Also write this file; its ending says how. Repeatable."),
    ] = None,
    tree_height: survey_input.TreeHeight = None,
    tree_gap: survey_input.TreeGap = None,
    ground_height: survey_input.GroundHeight = None,
    heading: survey_input.Heading = None,
    flight_height: survey_input.FlightHeight = None,
    block: survey_input.Block = None,
    settings: survey_input.Settings = None,
    yes: survey_input.Yes = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing.")] = False,
) -> None:
    """Turn a survey into a mission: the Π over its rows, smooth, timed and checked."""
    from orchard_cli import mission as missions
    from orchard_cli import survey as surveys
    from orchard_cli.model.mission import Provenance

    for path in exports or ():
        chosen_format(path, None)  # a wrong ending is told before the work
    options = survey_input.given_from(
        tree_height, tree_gap, ground_height, heading, flight_height, block, settings
    )
    surveyed = surveys.load(survey, options)
    survey_input.confirm(surveyed, yes, quiet or as_json)
    out = output or mission_path(survey)
    provenance = Provenance(
        survey=surveyed.file,
        survey_sha256=surveyed.sha256,
        tool_version=__version__,
        created_utc=datetime.now(UTC).isoformat(timespec="seconds"),
    )
    try:
        mission = missions.plan(surveyed.orchard, surveyed.wishes, provenance)
    except InputError as error:
        raise InputError(
            Fault(f"{survey.name}: {f.where}", f.what, f.mend) for f in error.faults
        ) from error
    missions.save(mission, out)
    for path in exports or ():
        write_export([mission], chosen_format(path, None), path)
    told = surveyed.recognised.notes if surveyed.recognised else ()
    notes = (*told, *missions.notes(mission))
    figures = summary(mission, missions.measured_corner_cut(mission), notes)
    if as_json:
        json.dump({**figures, "mission": str(out)}, sys.stdout)
        sys.stdout.write("\n")
    elif not quiet:
        _print(mission.name, figures, out)


def mission_path(survey: Path) -> Path:
    """Where a survey's mission goes: north.survey.toml -> north.mission.json beside it."""
    stem = survey.stem.removesuffix(".survey")
    return survey.with_name(f"{stem}.mission.json")


def summary(mission: Mission, corner_cut: float, notes: tuple[str, ...]) -> dict[str, Any]:
    """The figures of a planned mission, for people and for scripts."""
    return {
        "route_length_m": round(mission.route_length, 3),
        "waypoints": len(mission.waypoints_site),
        "duration_s": round(mission.duration, 2),
        "control_points": len(mission.spline.control_points_site),
        "corner_cut_m": round(corner_cut, 3),
        "energy_share": round(mission.energy_share, 4),
        "flight_s": round(mission.trajectory.end, 2),
        "rows": len(mission.orchard.rows),
        "trees": sum(len(row.heights) for row in mission.orchard.rows),
        "notes": list(notes),
    }


def _print(name: str, figures: dict[str, Any], out: Path) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(name), show_header=False, title_justify="left")
    table.add_row("route", f"{figures['route_length_m']:.2f} m, {figures['waypoints']} waypoints")
    table.add_row("orchard", f"{figures['rows']} rows, {figures['trees']} trees")
    table.add_row("spline", f"{figures['control_points']} control points")
    table.add_row("corners", f"cut by {figures['corner_cut_m']:.2f} m at most")
    table.add_row(
        "time",
        f"{figures['duration_s']:.0f} s first to last waypoint, {figures['flight_s']:.0f} s "
        "with run-up and run-out",
    )
    table.add_row("battery", f"{figures['energy_share']:.0%} of it, by hover endurance")
    table.add_row("mission", str(out))
    console = Console()
    console.print(table)
    for note in figures["notes"]:
        console.print(f"note: {note}", highlight=False)
