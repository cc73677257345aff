"""Every avoidance system in every world of missions/, on the same metrics: the grand table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from .desk import Desk
from .flights import Outcome, Task
from .rows import Row

if TYPE_CHECKING:
    from orchard_cli.analysis import Flight
    from orchard_cli.model.mission import Mission

TITLE = "Every system in every world"
SYSTEMS = ("none", "guided", "ego", "zones", "astar", "astar-fused", "dfa")
CAMERA = (424, 240)  # pixels: `fly` has 848 x 480, which takes four times as long to draw
METRICS = {  # as `orchard analyze` names them, and their units
    "contacts": "",
    "clearance_min_m": "m",
    "deviation_max_m": "m",
    "deviation_mean_m": "m",
    "avoidances": "",
    "replan_failures": "",
    "duration_s": "s",
    "speed_max_m_s": "m/s",
    "acceleration_max_m_s2": "m/s²",
    "coverage_percent": "%",
}


@dataclass(frozen=True, slots=True, eq=False)
class Flown:
    """One system in one world."""

    world: str
    system: str
    task: Task
    outcome: Outcome

    @property
    def ended(self) -> str:
        """How it went, in a few words."""
        if self.outcome.failed:
            return self.outcome.failed
        touched = self.outcome.figure("contacts")
        whole = self.outcome.figure("duration_s") is not None
        return (
            f"{'touched something; ' if touched else ''}{'whole route' if whole else 'not whole'}"
        )


def grand(desk: Desk) -> list[Row]:
    """Systems by worlds by metrics, with worlds.md and worlds.png beside the logs."""
    from .worlds_shown import markdown, picture

    cases = [(world, system) for world in worlds() for system in SYSTEMS]
    tasks = [_task(desk, world, system) for world, system in cases]
    desk.say(f"{TITLE}: {len(tasks)} flights")
    flown = [
        Flown(world.name.removesuffix(".world.toml"), system, task, outcome)
        for (world, system), task, outcome in zip(cases, tasks, desk.fly_all(tasks), strict=True)
    ]
    (desk.folder / "worlds.md").write_text(markdown(flown), encoding="utf-8")
    picture(desk.folder / "worlds.png", flown)
    return [row for one in flown for row in _rows(one)]


TABLES = {"worlds": grand}


def worlds() -> list[Path]:
    """World files that have a mission. Raises InputError when there are none."""
    from orchard_cli.commands.shipped import MISSIONS, missing

    found = sorted(
        world for world in MISSIONS.glob("*.world.toml") if _mission_file(world).exists()
    )
    if not found:
        raise missing(MISSIONS)
    return found


def _mission_file(world: Path) -> Path:
    return world.with_name(world.name.removesuffix(".world.toml") + ".mission.json")


def _task(desk: Desk, world: Path, system: str) -> Task:
    from orchard_cli import mission as missions
    from orchard_cli.commands.wiring import Choices

    mission: Mission = missions.load(_mission_file(world))
    choices = Choices(system=system, seed=desk.seed, camera=CAMERA)
    name = f"{world.name.removesuffix('.world.toml')}-{system}"
    toml = world.read_text(encoding="utf-8")
    return Task.of(desk.folder, name, mission, toml, choices, desk.reuse)


def _rows(one: Flown) -> Iterator[Row]:
    for number, (metric, unit) in enumerate(METRICS.items()):
        value = one.outcome.figure(metric)
        note = "" if value is not None else one.outcome.why_not(metric)
        if number == 0:
            note = "; ".join(filter(None, (f"senses by {senses(one.system)}", one.ended, note)))
        yield Row(one.world, one.system, metric, None, value, unit, note)


def senses(system: str) -> str:
    """What a system flies by. A simulated vehicle has all of it; a real one is asked first."""
    from orchard_cli.commands.systems import needs_of

    return "nothing" if system == "none" else ", ".join(("depth", *sorted(needs_of(system))))


def measured_flights(flown: Sequence[Flown]) -> Iterator[tuple[Flown, Flight]]:
    """Those that have a log."""
    from orchard_cli.commands.analyze_logs import measured

    for one in flown:
        if not one.outcome.failed:
            yield one, measured(one.task.log)
