"""`orchard export MISSION -o FILE`: a mission for other tools, or a picture of it."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchard_cli.errors import Fault, InputError

if TYPE_CHECKING:
    from orchard_cli.mission.exports import Format, Pump
    from orchard_cli.model.mission import Mission

_ENDINGS = {
    ".plan": "plan", ".waypoints": "wpl", ".wpl": "wpl", ".kml": "kml", ".geojson": "geojson",
    ".csv": "csv", ".kmz": "wpml", ".svg": "svg", ".png": "png", ".html": "html",
}  # fmt: skip
_FORMATS = "plan, wpl, kml, geojson, csv, wpml, svg, png or html"
_LARGEST = 50_000_000  # bytes of a file that is to be written over


def export(
    mission: Annotated[
        list[Path], typer.Argument(help="Mission file; for a picture, all sorties of an orchard.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="The file to write.")],
    form: Annotated[
        str | None, typer.Option("--format", help=f"{_FORMATS}. Default: by the file's ending.")
    ] = None,
    pump: Annotated[
        str,
        typer.Option(
            help="How plan and wpl run the pump: sprayer, servo (ArduPilot), actuator (PX4)."
        ),
    ] = "sprayer",
    pump_number: Annotated[
        int | None, typer.Option(help="Servo output (default 9) or actuator (default 1).")
    ] = None,
    pump_on: Annotated[
        int, typer.Option(min=500, max=2500, help="Servo pulse, pump on, µs.")
    ] = 1900,
    pump_off: Annotated[
        int, typer.Option(min=500, max=2500, help="Servo pulse, pump off, µs.")
    ] = 1100,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing.")] = False,
) -> None:
    """Write a mission for QGroundControl, Mission Planner, DJI, maps and tables, or draw it."""
    from orchard_cli import mission as missions

    chosen = chosen_format(output, form)
    how = chosen_pump(pump, pump_number, pump_on, pump_off)
    plans = [missions.load(path) for path in mission]
    size = write_export(plans, chosen, output, how)
    warn_of_obstacles(plans, chosen)
    if as_json:
        json.dump({"file": str(output), "format": chosen.value, "bytes": size}, sys.stdout)
        sys.stdout.write("\n")
    elif not quiet:
        typer.echo(f"{output}: {chosen.value}, {size} bytes")


def chosen_format(output: Path, form: str | None) -> Format:
    """The format that was named, else the one of the file's ending. Raises InputError."""
    from orchard_cli.mission.exports import Format

    name = form if form is not None else _ENDINGS.get(output.suffix.lower())
    if name is None:
        raise InputError(
            Fault(str(output), "its ending names no format", f"give --format: {_FORMATS}")
        )
    if name not in [known.value for known in Format]:
        raise InputError(Fault("--format", f"is {name!r}", f"use {_FORMATS}"))
    return Format(name)


def chosen_pump(by: str, number: int | None, on_us: int, off_us: int) -> Pump:
    """How to run the pump. Raises InputError with every fault."""
    from orchard_cli.mission.exports import Pump, PumpBy

    kinds = [kind.value for kind in PumpBy]
    if by not in kinds:
        raise InputError(Fault("--pump", f"is {by!r}", f"use {', '.join(kinds)}"))
    kind = PumpBy(by)
    most = 4 if kind is PumpBy.ACTUATOR else 32
    usual = 1 if kind is PumpBy.ACTUATOR else 9
    chosen = usual if number is None else number
    if not 1 <= chosen <= most:
        raise InputError(Fault("--pump-number", f"is {chosen}", f"give 1 to {most}"))
    if not off_us < 1500 < on_us:
        raise InputError(
            Fault("--pump-on", f"{on_us} µs and off {off_us} µs", "on is above 1500, off below")
        )
    return Pump(kind, chosen, on_us, off_us)


def write_export(plans: list[Mission], form: Format, output: Path, pump: Pump | None = None) -> int:
    """Write the file, all or nothing; returns its size.

    Raises InputError where it cannot be written, and where something stands that was no export.
    """
    from orchard_cli.mission.exports import export as exported
    from orchard_cli.model.output_file import replace

    data = exported(plans, form, pump)
    try:
        target = output.resolve()
        if os.path.lexists(target):
            _refuse_what_is_not_ours(target, str(output), form)
        replace(target, data)
    except (OSError, RuntimeError) as error:  # RuntimeError: a link that leads to itself
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(Fault(str(output), f"cannot be written: {reason}")) from error
    return len(data)


def _refuse_what_is_not_ours(target: Path, where: str, form: Format) -> None:
    """A wrong -o must not cost the crew a survey, a mission or a log."""
    from orchard_cli.mission.exports import is_own
    from orchard_cli.model.input_text import read_bounded

    if not target.is_file():
        raise InputError(Fault(where, "is no regular file", "choose another with -o"))
    if not is_own(read_bounded(target, _LARGEST), form):
        raise InputError(
            Fault(
                where,
                f"is there already and is no {form.value} export",
                "move it away, or choose another with -o",
            )
        )


def warn_of_obstacles(plans: list[Mission], form: Format) -> None:
    """Whoever flies the file has nothing that goes round them."""
    from orchard_cli.mission import notes

    if form.is_picture:
        return
    for note in sorted({note for plan in plans for note in notes(plan)}):
        where = note.removesuffix("; it will be avoided in flight")
        typer.echo(f"orchard: warning: {where}; nothing in this file avoids it", err=True)
