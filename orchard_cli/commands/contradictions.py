"""Options of `orchard fly` that do not go together."""

from __future__ import annotations

from pathlib import Path

from orchard_cli.errors import Fault, InputError

from .wiring import Choices


def refuse_contradictions(
    connect: str | None, world: Path | None, lockstep: bool, choices: Choices
) -> None:
    """A real vehicle has no other clock than the real one, a world file only on the bench, and
    never the eyes of another day. Raises InputError."""
    real, hurried = connect is not None, choices.speed_factor != 1
    rendered, logged = choices.rendered_camera, choices.logged_camera is not None
    wrong = (
        (real and lockstep, "--lockstep", "is the simulator's; leave it out with --connect"),
        (real and hurried, "--speed-factor", "cannot hurry a real vehicle; leave it out"),
        (real and world is not None and not rendered, "--world", "needs --rendered-camera"),
        (rendered and not (real and world), "--rendered-camera", "needs --connect, --world"),
        (lockstep and hurried, "--speed-factor", "lockstep goes as fast as it can"),
        (real and logged, "--logged-camera", "is the simulator's; leave it out with --connect"),
        (
            logged and choices.detector is not None,
            "--logged-camera",
            "shows depth alone; leave out --detector",
        ),
    )
    faults = [Fault(where, what) for is_wrong, where, what in wrong if is_wrong]
    if faults:
        raise InputError(faults)
