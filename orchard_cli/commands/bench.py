"""`orchard bench`: repeatable figures for every stage of the onboard work."""

from __future__ import annotations

import json as json_module
from pathlib import Path
from typing import Annotated

import typer

from .demo import NAME
from .shipped import MISSIONS


def bench(
    system: Annotated[
        list[str] | None, typer.Option(help="Avoidance system; repeat for more. Default: all.")
    ] = None,
    frames: Annotated[
        Path | None, typer.Option(help="Replay the depth images of this log instead.")
    ] = None,
    compare: Annotated[
        Path | None, typer.Option(help="An older --json document: print new over old.")
    ] = None,
    octomap: Annotated[
        bool, typer.Option("--octomap", help="Run OctoMap on the same frames (pyoctomap).")
    ] = False,
    quick: Annotated[
        bool, typer.Option("--quick", help="A few of everything, to see that it works.")
    ] = False,
    seed: Annotated[int, typer.Option(help="Seed of the pole fields.")] = 0,
    json: Annotated[bool, typer.Option("--json", help="One JSON document on stdout.")] = False,
) -> None:
    """Measure mapping, planning, the whole onboard cycle and the simulator on this machine."""
    from .benchmarks import document
    from .benchmarks.run import Plan, planners, run

    old = None if compare is None else document.load(compare)
    plan = Plan(
        mission=MISSIONS / f"{NAME}.mission.json",
        world=MISSIONS / f"{NAME}.world.toml",
        systems=tuple(system or planners()),
        frames_log=frames,
        octomap=octomap,
        seed=seed,
    )
    found = run(plan.quick() if quick else plan)
    if old is not None:
        found["ratios"] = document.ratios(found, old)
    if json:
        typer.echo(json_module.dumps(found, indent=2, allow_nan=False))
    else:
        from .benchmarks.tables import show

        show(found)
