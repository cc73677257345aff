"""`orchard demo`: the whole walk on the lemon orchard of Liu 2024."""

from __future__ import annotations

import json as json_module
from pathlib import Path
from typing import Annotated

import typer

NAME = "lemon-gazebo"


def demo(
    out: Annotated[Path, typer.Option(help="Folder for what the demo makes.")] = Path("demo"),
    system: Annotated[str, typer.Option(help="guided, ego, zones or none.")] = "guided",
    seed: Annotated[int, typer.Option(min=0, help="Seed of the simulator's noise and wind.")] = 0,
    speed_factor: Annotated[
        float, typer.Option(min=0.1, max=20, help="Simulated seconds per real second.")
    ] = 4.0,
    camera: Annotated[str, typer.Option(help="Depth mode of the simulated camera.")] = "848x480",
    json: Annotated[bool, typer.Option("--json", help="One JSON document on stdout.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No live screen.")] = False,
) -> None:
    """Plan the paper's lemon orchard, fly it in the simulator over MAVSDK, and measure the log."""
    from .apart import fly_apart

    tell_log = fly_apart(json, lambda summary: {"flight": summary})
    from orchard_cli import mission as missions

    from .analyze import draw, published
    from .analyze_document import document
    from .analyze_logs import measured
    from .camera_options import camera_mode
    from .fly import demand_as_planned, fly_mission
    from .plan import plan
    from .shipped import shipped
    from .wiring import Choices

    survey, world = shipped(f"{NAME}.survey.toml"), shipped(f"{NAME}.world.toml")
    choices = Choices(
        system=system, seed=seed, speed_factor=speed_factor, camera=camera_mode(camera)
    )
    out.mkdir(parents=True, exist_ok=True)
    mission_file, log_file = out / "mission.json", out / "flight.mcap"
    tell_log(log_file)
    plan(survey, mission_file, quiet=quiet or json)
    mission = missions.load(mission_file)
    ending, summary = fly_mission(
        mission, choices, log_file, world, quiet=quiet or json, overwrite=True
    )
    result = measured(log_file)
    report = document([result])
    (out / "metrics.json").write_text(json_module.dumps(report, indent=2, allow_nan=False))
    draw(out / "overview.png", [result])
    if json:
        typer.echo(json_module.dumps({**report, "flight": summary}, allow_nan=False))
    elif not quiet:
        from .analyze_table import show

        show([result], published("auto", [result]))
        typer.echo(
            f"flown at {summary['speed_factor']} times real time; "
            f"{log_file} opens in Foxglove, {out / 'overview.png'} shows the flight"
        )
    demand_as_planned(ending)
