"""Liu 2024: `guided` beside the baseline, in the orchards of Tables 1 and 2, flown in lockstep.

Each system flies each orchard with several seeds: of noise, wind and what follows from them.
"""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median
from typing import TYPE_CHECKING

from .desk import Desk
from .rows import Row

if TYPE_CHECKING:
    from orchard_cli.analysis.paper import Published

    from .flights import Outcome, Task

TITLE = "Liu 2024: lemon orchards, the method and EGO-Planner"
_SYSTEMS = ("guided", "ego")  # as the paper's columns: proposed, ego
_UNITS = {"_m_s2": "m/s²", "_m_s": "m/s", "_rad_s": "rad/s", "_m": "m", "_s": "s"}
_BESIDES = ("clearance_min_m", "height_error_max_m")
"""Of the flights here; the paper's tables do not tell."""


def table1(desk: Desk) -> list[Row]:
    """The orchard in Gazebo."""
    return _flights(desk, "Table 1", "lemon-gazebo", "liu2024-table1")


def table2(desk: Desk) -> list[Row]:
    """The orchard in the field."""
    return _flights(desk, "Table 2", "lemon-field", "liu2024-table2")


TABLES = {"1": table1, "2": table2}


def _flights(desk: Desk, table: str, orchard: str, figures: str) -> list[Row]:
    from orchard_cli.analysis.paper import PUBLISHED

    seeds = range(desk.seed, desk.seed + desk.seeds)
    tasks = {system: _tasks(desk, orchard, system, seeds) for system in _SYSTEMS}
    desk.say(f"{table}: {len(_SYSTEMS)} systems, seeds {seeds[0]} to {seeds[-1]}")
    outcomes = iter(desk.fly_all([task for of_one in tasks.values() for task in of_one]))
    rows = []
    for system, paper in zip(_SYSTEMS, PUBLISHED[figures], strict=True):
        rows += _rows(table, system, paper, [next(outcomes) for _ in tasks[system]])
    _picture(desk, table, [of_one[0] for of_one in tasks.values()])
    return rows


def _tasks(desk: Desk, orchard: str, system: str, seeds: Sequence[int]) -> list[Task]:
    from orchard_cli import mission as missions
    from orchard_cli.commands.shipped import shipped
    from orchard_cli.commands.wiring import Choices

    from .flights import Task

    file, world = shipped(f"{orchard}.mission.json"), shipped(f"{orchard}.world.toml")
    mission, toml = missions.load(file), world.read_text(encoding="utf-8")
    return [
        Task.of(
            desk.folder, f"{orchard}-{system}-{seed}", mission, toml,
            Choices(system=system, seed=seed), desk.reuse,
        )
        for seed in seeds
    ]  # fmt: skip


def _rows(table: str, system: str, paper: Published, flown: Sequence[Outcome]) -> list[Row]:
    names = (*paper.figures, *_BESIDES)
    notes = {names[0]: "; ".join(paper.notes)}
    rows = [
        _row(table, system, name, paper.figures.get(name), flown, notes.get(name, ""))
        for name in names
    ]
    contacts = [one.figure("contacts") for one in flown]
    known = [count for count in contacts if count is not None]
    total = sum(known) if len(known) == len(contacts) else None
    return [*rows, Row(table, system, "contacts", None, total, "", f"in {len(flown)} flights")]


def _row(
    table: str, system: str, name: str, paper: float | None, flown: Sequence[Outcome], note: str
) -> Row:
    found = [value for one in flown if (value := one.figure(name)) is not None]
    missing = [f"{one.name}: {one.why_not(name)}" for one in flown if one.figure(name) is None]
    note = "; ".join(filter(None, (note, *missing)))
    if not found:
        return Row(table, system, name, paper, None, _unit(name), note)
    if len(flown) == 1:
        return Row(table, system, name, paper, found[0], _unit(name), note)
    return Row(
        table, system, name, paper, median(found), _unit(name), note,
        len(found), min(found), max(found),
    )  # fmt: skip


def _picture(desk: Desk, table: str, tasks: Sequence[Task]) -> None:
    """The first flight of each system over the orchard with its trees and poles."""
    from orchard_cli.commands.analyze import draw
    from orchard_cli.commands.analyze_logs import measured

    flown = [measured(task.log) for task in tasks if task.log.exists()]
    if flown:
        draw(desk.folder / f"{table.lower().replace(' ', '')}.png", flown)


def _unit(name: str) -> str:
    return next(unit for ending, unit in _UNITS.items() if name.endswith(ending))
