"""Flights of a reproduction: flown in lockstep where the same was not flown yet, then measured."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from orchard_cli import mission as missions
from orchard_cli.code_hash import code_hash
from orchard_cli.commands.wiring import Choices
from orchard_cli.model.mission import Mission
from orchard_cli.model.output_file import write_whole

Figures = Mapping[str, float | str]
"""Metrics by name; words where one could not be measured."""


@dataclass(frozen=True, slots=True)
class Task:
    """One flight for a worker: plain data, so that it travels to other processes.

    `name` names its files: NAME.world.toml, NAME.mcap and, once it is flown, NAME.flown.json.
    """

    folder: Path
    name: str
    mission: str  # as a mission file
    world: str  # as a world file
    choices: Choices
    reuse: bool = False  # a log of that name, whatever it was flown with

    @classmethod
    def of(
        cls, folder: Path, name: str, mission: Mission, world: str, choices: Choices, reuse: bool
    ) -> Task:
        """A flight of a mission."""
        return cls(folder, name, missions.dumps(mission), world, choices, reuse)

    @property
    def log(self) -> Path:
        """Its log file."""
        return self.folder / f"{self.name}.mcap"

    @property
    def record(self) -> Path:
        """What is kept of a flight that was flown to its end."""
        return self.folder / f"{self.name}.flown.json"

    @property
    def inputs(self) -> str:
        """A hash of all that the flight depends on, this package's code included."""
        chosen = json.dumps(asdict(self.choices), default=str, sort_keys=True)
        parts = (code_hash(), self.mission, self.world, chosen)
        return hashlib.sha256("\0".join(parts).encode()).hexdigest()


@dataclass(frozen=True, slots=True)
class Outcome:
    """A flight's metrics, or why there are none."""

    name: str
    figures: Figures = field(default_factory=dict)
    failed: str = ""

    def figure(self, name: str) -> float | None:
        """A metric that was measured."""
        found = self.figures.get(name)
        return None if found is None or isinstance(found, str) else float(found)

    def why_not(self, name: str) -> str:
        """Why a metric is not there."""
        return self.failed or str(self.figures.get(name, "not measured"))


def fly(task: Task) -> bool:
    """Fly it, unless that was done with the same inputs; whether it was flown now."""
    from orchard_cli.commands.fly import fly_mission

    kept = _kept(task)
    if task.log.exists() and (task.reuse or kept.get("inputs") == task.inputs):
        return False
    task.record.unlink(missing_ok=True)
    world = task.folder / f"{task.name}.world.toml"
    world.write_text(task.world, encoding="utf-8")
    mission = missions.loads(task.mission.encode(), task.name)
    fly_mission(mission, task.choices, task.log, world, lockstep=True, quiet=True, overwrite=True)
    _keep(task, {"inputs": task.inputs})
    return True


def fly_and_measure(task: Task) -> Outcome:
    """For a pool of workers: never raises; what was measured before is not measured again."""
    try:
        flown = fly(task)
        kept = _kept(task)
        if flown or "figures" not in kept:
            kept = {"inputs": kept.get("inputs", "not known"), "figures": _measure(task)}
            _keep(task, kept)
        return Outcome(task.name, kept["figures"])
    except Exception as error:
        return Outcome(task.name, failed=f"{type(error).__name__}: {error}")


def _measure(task: Task) -> dict[str, float | str]:
    from orchard_cli.commands.analyze_logs import measured

    figures = measured(task.log).metrics.figures
    return {
        name: float(value) if isinstance(value, int | float) else str(value)
        for name, value in figures.items()
    }


def _kept(task: Task) -> dict[str, Any]:
    try:
        found = json.loads(task.record.read_bytes())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _keep(task: Task, what: dict[str, Any]) -> None:
    write_whole(task.record, json.dumps(what, indent=1) + "\n")
