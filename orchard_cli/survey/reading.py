"""Reading keys of a table with a fault for each that is wrong.

A wrong number reads as NaN and a wrong anything as its default, so that reading goes on and every
fault of a file is found in one go. Comparisons with NaN are false: later checks stay quiet about
what was already complained of.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from enum import Enum
from typing import Any, TypeVar

from orchard_cli.errors import Fault

Choice = TypeVar("Choice", bound=Enum)
_WIDE_SPACES = {0xA0: " ", 0x3000: " "}  # people type them; Python does not call them printable


class Table:
    """One table of a survey file. Every key that is read is known; `done` complains of the rest."""

    def __init__(self, values: Mapping[str, Any], where: str, faults: list[Fault]) -> None:
        self.where = where
        self.faults = faults
        self._values = values
        self._known: list[str] = []

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def fault(self, key: str, what: str, mend: str = "") -> None:
        """Complain of a key."""
        self.faults.append(Fault(f"{self.where}: {key}" if key else self.where, what, mend))

    def number(
        self,
        key: str,
        low: float,
        high: float,
        default: float | None = None,
        above_low: bool = False,
    ) -> float:
        """A number in [low, high], or (low, high] with `above_low`. No default: it is required."""
        if not self._has(key, default is None):
            return math.nan if default is None else default
        return self._checked(self._values[key], key, low, high, above_low)

    def whole(self, key: str, low: int, high: int, default: int) -> int:
        """An optional whole number in [low, high]."""
        value = self.number(key, low, high, default)
        if math.isfinite(value) and value % 1:
            self.fault(key, f"is {value:g}", "give a whole number")
        return int(value) if math.isfinite(value) else default

    def numbers(
        self, key: str, low: float, high: float, most: int, above_low: bool = False
    ) -> list[float]:
        """A required list of one to `most` numbers."""
        if not self._has(key, required=True):
            return []
        values = self._values[key]
        if not isinstance(values, list) or not values:
            self.fault(key, f"is {shown(values)}", "give a list of numbers, like [3.0, 3.2]")
            return []
        if len(values) > most:
            self.fault(key, f"has {len(values)} numbers", f"at most {most} are read")
            return []
        return [
            self._checked(value, f"{key}[{k}]", low, high, above_low)
            for k, value in enumerate(values, 1)
        ]

    def one_or_many(
        self, key: str, low: float, high: float, count: int, default: float | None = None
    ) -> list[float]:
        """A number for all, or a list of `count` numbers: `count` numbers."""
        if isinstance(self._values.get(key), list):
            values = self.numbers(key, low, high, most=100_000)
            if values and count and len(values) != count:
                self.fault(
                    key,
                    f"has {len(values)} numbers for {count} trees",
                    "give one number a tree (one more than there are gaps), or one for all",
                )
            return values if len(values) == count else [math.nan] * count
        return [self.number(key, low, high, default)] * count

    def point(self, key: str) -> list[float] | None:
        """An optional [x, y], m."""
        if not self._has(key, required=False):
            return None
        return self._point(self._values[key], key)

    def points(
        self, key: str, least: int = 3, most: int = 10_000, what: str = "polygon"
    ) -> list[list[float]]:
        """A required list of `least` to `most` [x, y], m; `what` names it in faults."""
        if not self._has(key, required=True):
            return []
        values = self._values[key]
        if not isinstance(values, list) or not least <= len(values) <= most:
            self.fault(
                key, f"is no {what}", f"give {least} to {most} points, like [[0, 0], [9, 0], ...]"
            )
            return []
        return [self._point(value, f"{key}[{k}]") for k, value in enumerate(values, 1)]

    def choice(self, key: str, kind: type[Choice], default: Choice) -> Choice:
        """One of an enumeration's values."""
        if not self._has(key, required=False):
            return default
        names = [item.value for item in kind]
        value = self._values[key]
        if value not in names:
            self.fault(key, f"is {shown(value)}", "use " + " or ".join(f'"{n}"' for n in names))
            return default
        return kind(value)

    def text(self, key: str, default: str) -> str:
        """A short text without control characters, which could rewrite a terminal."""
        if not self._has(key, required=False):
            return default
        value = self._values[key]
        if not isinstance(value, str) or not 0 < len(value) <= 200:
            self.fault(key, f"is {shown(value)}", "give a text of 1 to 200 characters")
            return default
        if not value.translate(_WIDE_SPACES).isprintable():
            self.fault(key, f"is {shown(value)}", "leave out control characters")
            return default
        return value

    def table(self, key: str, mend: str = "") -> Table:
        """A table within this one; empty when it is absent. With a `mend`, it is required.

        Only the absence of a required table is complained of, not that of its keys.
        """
        found = self._has(key, required=False)
        if mend and not found:
            self.fault(key, "the table is missing", mend)
            return Table({}, f"{self.where}: {key}", [])
        values = self._values[key] if found else {}
        if not isinstance(values, dict):
            self.fault(key, f"is {shown(values)}", f"write it as a table, [{key}]")
            values = {}
        return Table(values, f"{self.where}: {key}", self.faults)

    def tables(self, key: str, most: int) -> list[Table]:
        """The tables of an array of tables, [[key]]; their places are counted from 1."""
        if not self._has(key, required=False):
            return []
        values = self._values[key]
        if not isinstance(values, list) or not all(isinstance(v, dict) for v in values):
            self.fault(key, "is no list of tables", f"write each as [[{key}]]")
            return []
        if len(values) > most:
            self.fault(key, f"stands {len(values)} times", f"at most {most} are read")
            return []
        return [Table(v, f"{self.where}: {key} {k}", self.faults) for k, v in enumerate(values, 1)]

    def done(self) -> None:
        """Complain of each key that nobody asked for."""
        for key in self._values:
            if key not in self._known:
                near = difflib.get_close_matches(key, self._known, 1, 0.5)
                mend = f"did you mean {near[0]}?" if near else f"known: {', '.join(self._known)}"
                self.fault(shown(key).strip("'"), "is not known here", mend)

    def _has(self, key: str, required: bool) -> bool:
        self._known.append(key)
        if required and key not in self._values:
            self.fault(key, "is missing", "add it")
        return key in self._values

    def _checked(self, value: Any, key: str, low: float, high: float, above_low: bool) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.fault(key, f"is {shown(value)}, not a number", "give a number, like 3.5")
            return math.nan
        if low <= value <= high and not (above_low and value == low):
            return float(value)
        more = "more than " if above_low else ""
        self.fault(key, f"is {shown(value)}", f"give {more}{low:g} to {high:g}")
        return math.nan

    def _point(self, value: Any, key: str) -> list[float]:
        if not isinstance(value, list) or len(value) != 2:
            self.fault(key, f"is {shown(value)}", "give [x, y] in metres, like [4.0, 0.0]")
            return [math.nan, math.nan]
        return [self._checked(v, f"{key}[{k}]", -1e4, 1e4, False) for k, v in enumerate(value, 1)]


def shown(value: Any) -> str:
    """A value as a fault names it, never long."""
    try:
        text = repr(value)
    except ValueError:  # an integer of thousands of digits
        text = "a number of thousands of digits"
    return text if len(text) <= 40 else text[:37] + "..."
