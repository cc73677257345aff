"""Where a reproduction works: its folder, its seeds, and flights that are flown once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from orchard_cli.analysis import Flight
    from orchard_cli.commands.wiring import Choices
    from orchard_cli.model.mission import Mission

    from .flights import Outcome, Task


@dataclass(frozen=True, slots=True)
class Desk:
    """One run of `orchard reproduce`. What is made lies in `folder`; a flight whose log is there,
    flown with the same inputs, is not flown again."""

    folder: Path
    seed: int = 0
    reuse: bool = False  # logs in `folder`, whatever they were flown with
    quiet: bool = False
    seeds: int = 1  # flights of each kind, from `seed` on, in tables that are of several
    workers: int = 1

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

        from .flights import Task, fly

        self.say(f"flying {name}")
        task = Task.of(self.folder, name, mission, world_toml, choices, self.reuse)
        fly(task)
        flight = measured(task.log)
        draw(self.folder / f"{name}.png", [flight])
        return flight

    def fly_all(self, tasks: Sequence[Task]) -> list[Outcome]:
        """Fly and measure tasks, several at once; the same for any number of workers."""
        from orchard_cli.commands.pool import spread

        from .flights import fly_and_measure

        found = spread(fly_and_measure, tasks, self.workers, doing="flying", quiet=self.quiet)
        by_name = {outcome.name: outcome for outcome in found}
        return [by_name[task.name] for task in tasks]
