"""A file of tasks: [[task]] tables in the order in which they are flown."""

from __future__ import annotations

import math
from enum import Enum
from pathlib import Path

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.arrays import Vector
from orchard_cli.model.input_text import decoded, parse_toml, read_bounded
from orchard_cli.model.tasks import FlyTo, Hover, Land, TakeOff, Task

from .reading import Table

LARGEST = 2**20  # bytes
MOST = 1_000  # tasks
_EXAMPLE = '[[task]], then do = "takeoff", at_m = [0, -4], height_m = 3'


class Do(Enum):
    """The tasks' names in the file."""

    TAKEOFF = "takeoff"
    FLY = "fly"
    HOVER = "hover"
    LAND = "land"


def load_tasks(path: Path) -> tuple[Task, ...]:
    """The tasks of a file: one take-off first, one landing last, flights and hovers between.

    Raises InputError with every fault.
    """
    data = read_bounded(path, LARGEST, "fewer tasks a flight")
    faults: list[Fault] = []
    top = Table(parse_toml(decoded(data, path.name), path.name), path.name, faults)
    tables = top.tables("task", MOST)
    known = [_task(table) for table in tables]
    tasks = [task for task in known if task is not None]
    top.done()
    if not tasks and not faults:
        faults.append(Fault(path.name, "holds no task", f"begin with {_EXAMPLE}"))
    faults += _order(tasks, path.name) if len(tasks) == len(known) else []
    if faults:
        raise InputError(faults)
    return tuple(tasks)


def _task(table: Table) -> Task | None:
    """One task; None where what to do is not told, which is the only fault then."""
    before = len(table.faults)
    if "do" not in table:
        table.fault("do", "is missing", f"write do = one of {', '.join(d.value for d in Do)}")
    do = table.choice("do", Do, Do.LAND)
    if len(table.faults) > before:
        return None
    task: Task
    match do:
        case Do.TAKEOFF:
            task = TakeOff(_place(table, "at_m"), _finite(table.number("height_m", 0.5, 100)))
        case Do.FLY:
            high = "height_m" in table
            height = table.number("height_m", 0.5, 100) if high else None
            task = FlyTo(_place(table, "to_m"), None if height is None else _finite(height))
        case Do.HOVER:
            task = Hover(_finite(table.number("for_s", 0, 3600, above_low=True)))
        case Do.LAND:
            task = Land()
    table.done()
    return task


def _place(table: Table, key: str) -> Vector:
    """[x, y]; the origin where it is wrong, which a fault has told."""
    point = table.point(key)
    if point is None:
        table.fault(key, "is missing", f"write {key} = [x, y] in metres")
    place: Vector = np.nan_to_num(np.array(point or [0.0, 0.0]))
    return place


def _finite(value: float) -> float:
    """1 where a number was wrong, which a fault has told."""
    return value if math.isfinite(value) else 1.0


def _order(tasks: list[Task], file: str) -> list[Fault]:
    faults = []
    for k, task in enumerate(tasks, 1):
        first, last = k == 1, k == len(tasks)
        if isinstance(task, TakeOff) is not first:
            what = "is no take-off" if first else "takes off in the air"
            mend = "begin with the take-off" if first else "take off once, first"
            faults.append(Fault(f"{file}: task {k}", what, mend))
        if isinstance(task, Land) is not last:
            what = "is no landing" if last else "lands before the end"
            faults.append(Fault(f"{file}: task {k}", what, "land once, at the end"))
    return faults
