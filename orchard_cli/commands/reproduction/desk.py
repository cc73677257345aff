"""Where a reproduction works: its folder, its seed, and flights that are flown once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from orchard_cli.analysis import Flight
    from orchard_cli.commands.wiring import Choices
    from orchard_cli.model.mission import Mission


@dataclass(frozen=True, slots=True)
class Desk:
    """One run of `orchard reproduce`. What is made lies in `folder`; logs there are not flown again
    when `again` is False and they are whole."""

    folder: Path
    seed: int = 0
    again: bool = True
    quiet: bool = False

    def say(self, text: str) -> None:
        """Progress, to stderr."""
        if not self.quiet:
            typer.echo(text, err=True)

    def fly(self, name: str, mission: Mission, world_toml: str, choices: Choices) -> Flight:
        """Fly a mission in lockstep in a world of its own, log it and measure the log.

        `name` names the files: NAME.world.toml, NAME.mcap, NAME.png. The log says how it ended.
        """
        from orchard_cli.commands.analyze import draw
        from orchard_cli.commands.analyze_logs import measured
        from orchard_cli.commands.fly import fly_mission

        world, log = self.folder / f"{name}.world.toml", self.folder / f"{name}.mcap"
        if self.again or not log.exists() or not world.exists():
            self.say(f"flying {name}")
            world.write_text(world_toml, encoding="utf-8")
            fly_mission(mission, choices, log, world, lockstep=True, quiet=True, overwrite=True)
        flight = measured(log)
        draw(self.folder / f"{name}.png", [flight])
        return flight
