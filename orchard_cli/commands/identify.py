"""`orchard identify drift`: how far the sprayer drifts, and which avoidance velocity follows."""

from __future__ import annotations

import json as json_module
from typing import Annotated

import typer

identify_app = typer.Typer(
    help="Fly tests in the simulator and fit what a system must know of its vehicle.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@identify_app.callback()
def _options() -> None:
    """Fly tests in the simulator and fit what a system must know of its vehicle."""


@identify_app.command()
def drift(
    acceleration: Annotated[
        float, typer.Option(min=0.3, max=5.0, help="m/s² that the vehicle brakes with at most.")
    ] = 3.0,
    distance: Annotated[
        float, typer.Option(min=0.2, max=1.0, help="m of drift that is allowed.")
    ] = 0.59,
    json: Annotated[bool, typer.Option("--json", help="One JSON document on stdout.")] = False,
) -> None:
    """Stop the sprayer from several speeds with several loads; fit the avoidance velocity."""
    from .identification import LEVELS, SPEEDS, fly_test, identified

    tests = []
    for level in LEVELS:
        typer.echo(f"stopping with a level of {level}", err=True)
        tests += [fly_test(level, speed, acceleration) for speed in SPEEDS]
    typer.echo("looking for the speeds that drift so far", err=True)
    found, points = identified(acceleration, distance)
    document = {
        "schema": "orchard-identify/1",
        "acceleration_m_s2": acceleration,
        "tests": [
            {"level": t.level, "speed_m_s": t.speed, "drift_m": round(t.drift, 4)} for t in tests
        ],
        "avoidance": [
            {"level": x, "speed_m_s": round(v, 4), "fitted_m_s": round(found.speed(x), 4)}
            for x, v in points.tolist()
        ],
        "fit": {"a": found.a, "b": found.b, "c": found.c, "d": found.d, "drift_m": distance},
    }
    if json:
        typer.echo(json_module.dumps(document))
        return
    typer.echo("drift, m       " + "".join(f"{f'level {x:g}':>11}" for x in LEVELS))
    for speed in SPEEDS:
        cells = [t.drift for t in tests if t.speed == speed]
        typer.echo(f"from {speed:4.2f} m/s  " + "".join(f"{cell:11.2f}" for cell in cells))
    typer.echo(f"\nv_A(x) = {found.a:.4g} e^({found.b:.4g} x) + {found.c:.4g} e^({found.d:.4g} x)")
    for x, v in points.tolist():
        typer.echo(f"level {x:4.2f}: {v:.3f} m/s, fitted {found.speed(x):.3f}")
