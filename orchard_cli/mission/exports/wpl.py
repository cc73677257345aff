"""MAVLink's plain text of missions, "QGC WPL 110": one item a line, tabs between its numbers.

Format: mavlink.io, "File Formats". The first item is home, on the ground at take-off. The format
carries no fence.
"""

from __future__ import annotations

import math

from orchard_cli.errors import Fault, InputError

from .course import Course, Loaded
from .items import Command, Frame, Item, Pump, PumpBy, items, loaded

_HEAD = "QGC WPL 110"
_CELLS = 12


def write(course: Course, pump: Pump) -> bytes:
    """The text of a WPL file."""
    home = tuple(round(float(v), d) for v, d in zip(course.home_wgs84, (9, 9, 4), strict=True))
    listed = [Item(Command.WAYPOINT, Frame.GLOBAL, (0, 0, 0, 0, *home)), *items(course, pump)]
    unset = "nan" if pump.by is PumpBy.ACTUATOR else "0"  # a yaw of 0 turns PX4 to the north
    lines = [_HEAD]
    for number, item in enumerate(listed):
        params = [unset if value is None else _number(value) for value in item.params]
        head = (str(number), str(int(number == 0)), str(int(item.frame)), str(int(item.command)))
        lines.append("\t".join([*head, *params, "1"]))
    return ("\n".join(lines) + "\n").encode()


def _number(value: float) -> str:
    return f"{value:.9f}".rstrip("0").rstrip(".") if value % 1 else str(int(value))


def read(data: bytes) -> Loaded:
    """Read a WPL file. Raises InputError for anything else."""
    lines = data.decode("utf-8", "replace").splitlines()
    if not lines or lines[0].strip() != _HEAD:
        raise InputError(Fault("wpl", f"does not begin with {_HEAD}"))
    listed = []
    for number, line in enumerate(lines[1:], 2):
        cells = line.split("\t")
        try:
            values = [float(cell) for cell in cells]
        except ValueError as error:
            raise InputError(Fault(f"wpl, line {number}", str(error))) from error
        if len(values) != _CELLS:
            raise InputError(Fault(f"wpl, line {number}", f"has {len(cells)} cells, not {_CELLS}"))
        params = tuple(None if math.isnan(value) else value for value in values[4:11])
        listed.append(Item(int(values[3]), int(values[2]), params))
    return loaded(listed[1:])
