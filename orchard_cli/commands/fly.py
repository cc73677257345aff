"""`orchard fly MISSION`: the simulator by default, a real autopilot with --connect."""

from __future__ import annotations

import json as json_module
import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from orchard_cli.flight.gear import Ending
    from orchard_cli.model.mission import Mission

    from .wiring import Choices, Equipment


def fly(
    mission: Annotated[Path, typer.Argument(help="Mission file from `orchard plan`.")],
    connect: Annotated[
        str | None,
        typer.Option(help="Fly a REAL vehicle on this MAVSDK URL, like udpin://0.0.0.0:14540."),
    ] = None,
    world: Annotated[Path | None, typer.Option(help="World file for the simulator.")] = None,
    system: Annotated[str, typer.Option(help="guided, ego, zones, dfa, none, ....")] = "guided",
    yaw: Annotated[
        str | None, typer.Option(help="How the nose turns: steady, or published: EGO-Planner's.")
    ] = None,
    stops: Annotated[
        bool, typer.Option("--stops", help="Straight legs, with a stop in every waypoint.")
    ] = False,
    seed: Annotated[
        int | None,
        typer.Option(min=0, help="Seed of the simulator's noise and wind; default: the world's."),
    ] = None,
    speed_factor: Annotated[
        float, typer.Option(min=0.1, max=20, help="Simulated seconds per real second.")
    ] = 1.0,
    lockstep: Annotated[
        bool, typer.Option("--lockstep", help="Simulate without MAVSDK, as fast as it goes.")
    ] = False,
    camera: Annotated[str, typer.Option(help="Depth mode of the camera.")] = "848x480",
    camera_mount: Annotated[
        str,
        typer.Option(help="Place of the RealSense: FORWARD,LEFT,UP in m, DOWN in deg."),
    ] = "0.1,0,0,0",
    camera_filters: Annotated[
        str, typer.Option(help="The vendor's filters: spatial, holes, or both with a comma.")
    ] = "",
    camera_serial: Annotated[
        str, typer.Option(help="Serial number, where several RealSense are plugged in.")
    ] = "",
    vehicle: Annotated[
        str, typer.Option(help="x500, or sprayer: 20 kg and a tank of 32 l.")
    ] = "x500",
    level: Annotated[
        float, typer.Option(min=0, max=1, help="Of the sprayer's tank at take-off, 1 is full.")
    ] = 1.0,
    return_when_empty: Annotated[
        bool, typer.Option("--return-when-empty", help="Come back when the tank is empty.")
    ] = False,
    detector: Annotated[
        Path | None, typer.Option(help="ONNX model of the YOLO family with which zones sees.")
    ] = None,
    detector_names: Annotated[
        Path | None, typer.Option(help="Its class names, one a line; default: its metadata.")
    ] = None,
    mend_failsafes: Annotated[
        bool,
        typer.Option("--mend-failsafes", help="Write safe failsafe parameters to the autopilot."),
    ] = False,
    rendered_camera: Annotated[
        bool,
        typer.Option(
            "--rendered-camera",
            help="With --connect: see --world instead of a camera. Bench and SITL only.",
        ),
    ] = False,
    logged_camera: Annotated[
        Path | None,
        typer.Option(help="Log of a flight along the same way: the simulator sees its images."),
    ] = None,
    live: Annotated[
        bool, typer.Option("--live", help="Serve the flight to Foxglove on this computer.")
    ] = False,
    live_address: Annotated[
        str, typer.Option(help="HOST:PORT to serve it on, for another computer; implies --live.")
    ] = "",
    log: Annotated[Path | None, typer.Option(help="Log file; default: named by the time.")] = None,
    json: Annotated[bool, typer.Option("--json", help="One JSON document on stdout.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No live screen.")] = False,
) -> None:
    """Fly a mission, mapping and avoiding on the way; Ctrl-C holds."""
    from .apart import fly_apart

    tell_log = _not_told if lockstep else fly_apart(json)
    from orchard_cli import mission as missions

    from .camera_options import camera_filters as filters_of
    from .camera_options import camera_mode
    from .camera_options import camera_mount as mount_of
    from .contradictions import refuse_contradictions
    from .loading import vehicle_choice
    from .wiring import Choices

    name, filled = vehicle_choice(vehicle, level)
    choices = Choices(
        system=system,
        yaw=yaw,
        stops=stops,
        detector=detector,
        detector_names=detector_names,
        vehicle=name,
        level=filled,
        return_when_empty=return_when_empty,
        seed=seed,
        speed_factor=speed_factor,
        camera=camera_mode(camera),
        mend_failsafes=mend_failsafes,
        rendered_camera=rendered_camera,
        logged_camera=logged_camera,
        serial=camera_serial,
        filters=filters_of(camera_filters),
        mount=mount_of(camera_mount),
    )
    refuse_contradictions(connect, world, lockstep, choices)
    plan = missions.load(mission)
    path = log if log is not None else default_log(plan.name)
    tell_log(path)
    address = live_address or ("127.0.0.1:8765" if live else "")
    ending, summary = fly_mission(
        plan, choices, path, world, connect, lockstep, quiet or json, live=address
    )
    if json:
        typer.echo(json_module.dumps(summary))
    elif not quiet:
        typer.echo(f"\n{ending.why}; log: {path}", err=True)
    if summary["log_losses"]:
        typer.echo(f"orchard: the log has lost records: {summary['log_losses']}", err=True)
    demand_as_planned(ending)


def _not_told(log: Path) -> None:
    """In lockstep nothing real can fly on, and nobody waits beside the flight."""


def demand_as_planned(ending: Ending) -> None:
    """Raises LinkError or FlightEndedEarly when the flight did not end as planned."""
    from orchard_cli.errors import FlightEndedEarly, LinkError

    if ending.trouble:
        raise LinkError(ending.why)
    if not ending.as_planned:
        raise FlightEndedEarly(f"the flight did not go as planned: {ending.why}")


def default_log(name: str) -> Path:
    """A log name that sorts by time and does not exist yet."""
    from datetime import UTC, datetime

    safe = re.sub(r"[^\w.-]+", "-", name)
    return Path(f"{safe}-{datetime.now(UTC):%Y%m%dT%H%M%SZ}.mcap")


def fly_mission(
    mission: Mission,
    choices: Choices,
    log: Path,
    world_path: Path | None = None,
    connect: str | None = None,
    lockstep: bool = False,
    quiet: bool = False,
    overwrite: bool = False,
    live: str = "",
) -> tuple[Ending, dict[str, Any]]:
    """Fly and log; returns how it ended, and a summary for `--json`.

    `live` is HOST:PORT to serve the flight on; empty: it is not served.
    """
    from orchard_cli.flightlog import McapRecorder, Tee

    from . import wiring
    from .conduct import run_header
    from .live_option import live_view
    from .loading import loaded
    from .systems import yaw_rule

    mission = loaded(mission, choices)
    yaw_rule(choices)  # an unknown one is told before anything is started
    world, world_file = wiring.load_world(mission, world_path)
    if connect is not None:
        rig = wiring.real(mission, connect, choices, world)
    elif lockstep:
        rig = wiring.lockstep(mission, world, choices)
    else:
        rig = wiring.simulated(mission, world, choices)
    watched = live_view(live)
    recorder = McapRecorder(log, overwrite=overwrite, patient=lockstep)
    records = Tee(recorder, *watched)
    try:
        with rig as equipment:
            records.write(run_header(mission, choices, equipment, world_file, connect is None))
            began = equipment.clock.now()
            ending = _run(mission, equipment, records, quiet, choices)
            flown = equipment.clock.now() - began
            factor = equipment.achieved_factor()
    finally:
        records.close()
    summary = {
        "as_planned": ending.as_planned,
        "ended": ending.why,
        "flight_s": round(flown, 2),
        "speed_factor": None if math.isnan(factor) else round(factor, 2),
        "log": str(log),
        "log_losses": dict(recorder.losses),
    }
    return ending, summary


def _run(
    mission: Mission, equipment: Equipment, recorder: Any, quiet: bool, choices: Choices
) -> Ending:
    from .conduct import conduct
    from .operator import Operator
    from .screen import LiveScreen, QuietScreen
    from .systems import yaw_rule

    operator = Operator()
    title = f"{mission.name} · {choices.system} · {equipment.name}"
    screen = QuietScreen() if quiet else LiveScreen(title, operator.attended)
    with operator.listening(), screen:
        return conduct(mission, equipment, recorder, operator, screen, yaw_rule(choices))
