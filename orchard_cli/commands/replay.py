"""`orchard replay LOG`: watch a flight again, or think it over again from its depth images."""

from __future__ import annotations

import json as json_module
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from .replaying.decisions import Rethought

SHOWN = 20  # differences that are printed


def replay(
    log: Annotated[Path, typer.Argument(help="Log of `orchard fly`.")],
    rethink: Annotated[
        bool,
        typer.Option("--rethink", help="Map and plan again on the logged depth images; compare."),
    ] = False,
    system: Annotated[
        str | None, typer.Option(help="With --rethink: the system that thinks; default: that flew.")
    ] = None,
    speed_factor: Annotated[
        float, typer.Option(min=0.1, max=1000, help="Flown seconds per real second.")
    ] = 8.0,
    json: Annotated[
        bool, typer.Option("--json", help="With --rethink: one JSON document.")
    ] = False,
) -> None:
    """Watch a logged flight on the live screen; --rethink tells where decisions differ today."""
    from orchard_cli.errors import Fault, InputError

    if not rethink and (json or system is not None):
        where = "--json" if json else "--system"
        raise InputError(Fault(where, "belongs to --rethink", "add it"))
    if rethink:
        from .replaying.decisions import rethink as again

        found = again(log, system)
        if json:
            typer.echo(json_module.dumps(found.document(), indent=2, allow_nan=False))
        else:
            _tell(found)
    else:
        _play(log, speed_factor)


def _play(path: Path, factor: float) -> None:
    from orchard_cli.errors import Fault, InputError
    from orchard_cli.flightlog import read

    from .analyze_logs import mission_of
    from .replaying.statuses import PERIOD, statuses
    from .screen import LiveScreen

    log = read(path)
    mission = mission_of(log, path)
    if len(log.odometry.times) < 2:
        raise InputError(Fault(str(path), "holds no flight to watch"))
    with LiveScreen(f"{path.name}, {factor:g} times as fast as flown", keys=False) as screen:
        due = time.monotonic()
        for status in statuses(log, mission):
            screen.show(status)
            due += PERIOD / factor
            time.sleep(max(0.0, due - time.monotonic()))
    for note in log.notes:
        typer.echo(f"orchard: {note}", err=True)


def _tell(found: Rethought) -> None:
    typer.echo(
        f"{found.frames} depth images in the log, of {found.cycles} cycles flown; "
        f"{found.replayed} thought over again by {found.system}, {found.same} decided the same"
    )
    if found.skipped:
        typer.echo(f"{found.skipped} left out: what was flown then is not in the log")
    for turn in found.turns:
        again = f"now {turn.again}" if turn.again else "its depth image is not in the log"
        typer.echo(f"at {turn.time:.2f} s: logged {turn.logged}; {again}")
    for one in found.differing[:SHOWN]:
        typer.echo(
            f"at {one.time:.2f} s: logged {one.logged} ({one.logged_why}), "
            f"now {one.again} ({one.again_why})"
        )
    if len(found.differing) > SHOWN:
        typer.echo(f"{len(found.differing) - SHOWN} more differ; --json tells all")
