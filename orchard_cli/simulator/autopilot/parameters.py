"""The autopilot's parameters: the part of PX4's table that this simulation obeys or shows."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import resources


@dataclass(frozen=True, slots=True)
class Entry:
    """One parameter of the table. Integers are PX4's INT32, the others float."""

    name: str
    integer: bool
    default: float
    least: float
    most: float


@cache
def table() -> tuple[Entry, ...]:
    """PX4 1.17's parameters that matter here, in order of name, with PX4's defaults.

    From PX4's own metadata of March 2026; NAV_ACC_RAD, RTL_RETURN_ALT, RTL_DESCEND_ALT,
    COM_LOW_BAT_ACT and COM_RC_IN_MODE as its multicopter and simulator start-up scripts set them,
    MPC_THR_HOVER as for the X500.
    """
    text = resources.files(__package__).joinpath("parameters.json").read_text(encoding="utf-8")
    return tuple(
        Entry(
            name,
            row["type"] == "int",
            row["default"],
            row.get("min", float("-inf")),
            row.get("max", float("inf")),
        )
        for name, row in json.loads(text).items()
    )


class Parameters:
    """Name → value, with PX4's types and limits."""

    def __init__(self, changed: dict[str, float] | None = None) -> None:
        self.entries = {entry.name: entry for entry in table()}
        self.order = tuple(self.entries)
        self._values = {name: entry.default for name, entry in self.entries.items()}
        self.version = 0
        for name, value in (changed or {}).items():
            self.set(name, value)

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def __contains__(self, name: object) -> bool:
        return name in self._values

    def __iter__(self) -> Iterator[str]:
        return iter(self.order)

    def __len__(self) -> int:
        return len(self.order)

    def set(self, name: str, value: float) -> None:
        """Set a value as PX4 does: unchecked against its limits. Raises KeyError when absent."""
        entry = self.entries[name]
        self._values[name] = int(value) if entry.integer else float(value)
        self.version += 1
