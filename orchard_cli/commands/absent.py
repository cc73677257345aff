"""What stands in a socket where nothing is plugged in."""

from __future__ import annotations

from orchard_cli.model.depth import d455


class NoGuard:
    """Fits `Guard` where nothing real can fly on: lockstep."""

    def feed(self) -> None:
        """Nothing to do."""

    def disarm(self) -> None:
        """Nothing to do."""


class NoCamera:
    """Fits `Camera` for flights without avoidance."""

    def __init__(self) -> None:
        self.model = d455()

    def latest(self) -> None:
        """Never a frame."""

    def close(self) -> None:
        """Nothing to let go of."""
