"""`orchard plan`: survey file -> mission file, or one for each sortie."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchard_cli import __version__
from orchard_cli.errors import Fault, InputError

from . import flight_options as fly_as
from . import survey_input
from .export import chosen_format, write_export
from .resume import resumed

if TYPE_CHECKING:
    from orchard_cli.mission.route import Pass
    from orchard_cli.model.mission import Mission
    from orchard_cli.model.tasks import Task
    from orchard_cli.survey import Survey


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
    resume_at: Annotated[
        str | None,
        typer.Option(help="Spray from here on: ROW:METRES from its first tree, or x,y in metres."),
    ] = None,
    resume_from: Annotated[
        list[Path] | None,
        typer.Option(help="Spray from where this flight's log stops. Repeatable."),
    ] = None,
    missed: Annotated[
        bool, typer.Option("--missed", help="With --resume-from: also what it missed before.")
    ] = False,
    tasks: Annotated[
        Path | None, typer.Option(help="Fly the tasks of this file instead of the rows.")
    ] = None,
    height: fly_as.Height = None,
    height_above: fly_as.HeightAbove = None,
    follow: fly_as.Follow = None,
    speed: fly_as.Speed = None,
    swath: fly_as.Swath = None,
    overlap: fly_as.Overlap = None,
    passes: fly_as.Passes = None,
    fly_over: fly_as.FlyOver = None,
    pattern: fly_as.Pattern = None,
    direction: fly_as.Direction = None,
    start_row: fly_as.StartRow = None,
    start_side: fly_as.StartSide = None,
    turn: fly_as.Turn = None,
    headland: fly_as.Headland = None,
    turn_radius: fly_as.TurnRadius = None,
    terrain: survey_input.TerrainFile = None,
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
    """Turn a survey into a mission: the Π over its rows, smooth, timed and checked.

    An orchard that takes more than a battery or a tank becomes several, one file each.
    """
    from orchard_cli import survey as surveys

    for path in exports or ():
        chosen_format(path, None)  # a wrong ending is told before the work
    options = survey_input.given_from(
        tree_height, tree_gap, ground_height, heading, flight_height, block, settings
    )
    keys = fly_as.flight_keys(
        height=height, height_above=height_above, follow=follow, speed=speed, swath=swath,
        overlap=overlap, passes=passes, fly_over=fly_over, pattern=pattern, direction=direction,
        start_row=start_row, start_side=start_side, turn=turn, headland=headland,
        turn_radius=turn_radius,
    )  # fmt: skip
    surveyed = surveys.load(survey, options, keys)
    survey_input.confirm(surveyed, yes, quiet or as_json)
    if terrain is not None:
        surveyed = survey_input.on_terrain(surveyed, terrain)
    left, remarks = _left(surveyed, resume_at, resume_from or [], missed)
    todo = None if tasks is None else surveys.load_tasks(tasks)
    try:
        missions = _planned(surveyed, left, todo)
    except InputError as error:
        raise InputError(
            Fault(f"{survey.name}: {f.where}", f.what, f.mend) for f in error.faults
        ) from error
    files = _saved(missions, output or mission_path(survey), exports or [])
    found = surveyed.recognised.notes if surveyed.recognised else ()
    _tell(
        _figures(missions, files, (*surveyed.remarks, *found)),
        missions[0].name,
        remarks,
        as_json,
        quiet,
    )


def _left(
    surveyed: Survey, at: str | None, logs: Sequence[Path], missed: bool
) -> tuple[list[Pass] | None, list[str]]:
    """What a resumed flight has to spray, and what to tell about it; None: the whole orchard."""
    if at is not None or logs:
        return resumed(surveyed, at, logs, missed)
    if missed:
        raise InputError(Fault("--missed", "needs a log", "give --resume-from"))
    return None, []


def _planned(
    surveyed: Survey, left: list[Pass] | None, todo: Sequence[Task] | None
) -> tuple[Mission, ...]:
    from orchard_cli import mission as missions
    from orchard_cli.model.mission import Provenance

    provenance = Provenance(
        survey=surveyed.file,
        survey_sha256=surveyed.sha256,
        tool_version=__version__,
        created_utc=datetime.now(UTC).isoformat(timespec="seconds"),
    )
    orchard, wishes = surveyed.orchard, surveyed.wishes
    if todo is not None:
        if left is not None:
            raise InputError(Fault("--tasks", "resumes nothing", "leave out --resume-..."))
        return (missions.plan_tasks(orchard, wishes, provenance, todo),)
    if left is None:
        return missions.plan_sorties(orchard, wishes, provenance)
    return missions.plan_from_home(orchard, wishes, provenance, left)


def _saved(missions: Sequence[Mission], out: Path, exports: Sequence[Path]) -> list[Path]:
    """Write all files; returns the missions' own."""
    from orchard_cli.mission import save

    files = [_of_sortie(out, mission) for mission in missions]
    for mission, path in zip(missions, files, strict=True):
        save(mission, path)
    for path in exports:
        form = chosen_format(path, None)
        if form.is_picture:
            write_export(list(missions), form, path)
        else:
            for mission in missions:
                write_export([mission], form, _of_sortie(path, mission))
    return files


def mission_path(survey: Path) -> Path:
    """Where a survey's mission goes: north.survey.toml -> north.mission.json beside it."""
    stem = survey.stem.removesuffix(".survey")
    return survey.with_name(f"{stem}.mission.json")


def _of_sortie(path: Path, mission: Mission) -> Path:
    """north.mission.json -> north-1of3.mission.json; as it is where there is one flight."""
    if mission.sortie is None:
        return path
    stem, *endings = path.name.split(".")
    name = f"{stem}-{mission.sortie.number}of{mission.sortie.of}"
    return path.with_name(".".join([name, *endings]))


def summary(mission: Mission, corner_cut: float, notes: tuple[str, ...]) -> dict[str, Any]:
    """The figures of a planned mission, for people and for scripts."""
    sprayed = [segment.row for segment, _ in mission.spray_lines if segment.row is not None]
    figures: dict[str, Any] = {
        "route_length_m": round(mission.route_length, 3),
        "waypoints": len(mission.waypoints_site),
        "duration_s": round(mission.duration, 2),
        "control_points": len(mission.spline.control_points_site),
        "corner_cut_m": round(corner_cut, 3),
        "energy_share": round(mission.energy_share, 4),
        "flight_s": round(mission.trajectory.end, 2),
        "rows": len(mission.orchard.rows),
        "trees": sum(len(row.heights) for row in mission.orchard.rows),
        "sprayed_rows": sorted({row + 1 for row in sprayed}),
        "notes": list(notes),
    }
    if mission.liquid is not None:
        figures["liquid_l"] = round(mission.liquid, 3)
    if mission.sortie is not None:
        figures["sortie"] = mission.sortie.number
    return figures


def _figures(
    missions: Sequence[Mission], files: Sequence[Path], found: Sequence[str]
) -> list[dict[str, Any]]:
    """Each mission's figures, with what was found in the survey as the first notes."""
    from orchard_cli.mission import measured_corner_cut, notes

    return [
        {
            **summary(mission, measured_corner_cut(mission), (*found, *notes(mission))),
            "mission": str(path),
        }
        for mission, path in zip(missions, files, strict=True)
    ]


def _tell(
    told: Sequence[dict[str, Any]], name: str, remarks: Sequence[str], as_json: bool, quiet: bool
) -> None:
    if as_json:
        document = told[0] if len(told) == 1 else _totals(told)
        json.dump({**document, "remarks": list(remarks)} if remarks else document, sys.stdout)
        sys.stdout.write("\n")
    elif not quiet:
        _print(name, told, remarks)


def _totals(told: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Sums over the sorties, and each of them."""
    sums = ("route_length_m", "waypoints", "duration_s", "control_points", "flight_s", "liquid_l")
    totals = {key: round(sum(t[key] for t in told), 3) for key in sums if key in told[0]}
    return {**totals, "sorties": list(told)}


def _print(name: str, told: Sequence[dict[str, Any]], remarks: Sequence[str]) -> None:
    from rich.console import Console

    console = Console()
    console.print(_table(name, told[0]) if len(told) == 1 else _sorties(name, told))
    for note in dict.fromkeys(note for figures in told for note in figures["notes"]):
        console.print(f"note: {note}", highlight=False, markup=False)
    for remark in remarks:
        console.print(remark, highlight=False, markup=False)


def _table(name: str, figures: dict[str, Any]) -> Any:
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
    if "liquid_l" in figures:
        table.add_row("liquid", f"{figures['liquid_l']:.2f} l")
    table.add_row("mission", Text(figures["mission"]))
    return table


def _sorties(name: str, told: Sequence[dict[str, Any]]) -> Any:
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(f"{name}: {len(told)} sorties"), title_justify="left")
    for heading in ("", "rows", "route", "in the air", "battery", "liquid", "mission"):
        table.add_column(heading)
    for figures in told:
        rows = figures["sprayed_rows"]
        table.add_row(
            str(figures["sortie"]),
            ", ".join(map(str, rows)) if len(rows) < 6 else f"{rows[0]} .. {rows[-1]}",
            f"{figures['route_length_m']:.0f} m",
            f"{figures['flight_s']:.0f} s",
            f"{figures['energy_share']:.0%}",
            f"{figures['liquid_l']:.2f} l" if "liquid_l" in figures else "",
            Text(figures["mission"]),
        )
    return table
