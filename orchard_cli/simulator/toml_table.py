"""One table of a TOML document: values with their bounds, faults with their key path."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from orchard_cli.errors import Fault
from orchard_cli.model.arrays import Vector


class Table:
    """Reads keys and notes what is wrong with them; a faulty value reads as a harmless one.

    The faults list is shared by a document's tables; whoever reads the document looks into it at
    the end, before the values are used.
    """

    def __init__(
        self, values: Mapping[str, Any], source: str, path: str, faults: list[Fault]
    ) -> None:
        self._values = values
        self._source = source
        self._path = path
        self._faults = faults
        self._known: set[str] = set()
        self.faulty = False  # whether a fault of this very table was noted

    def fault(self, key: str, what: str, mend: str = "") -> None:
        """Note that the value of a key is wrong."""
        self.faulty = True
        place = f"{self._path}.{key}" if self._path else key
        self._faults.append(Fault(f"{self._source}, {place}", what, mend))

    def number(self, key: str, default: float | None, low: float, high: float) -> float:
        """A finite number in [low, high]; a default of None means that the key must be there."""
        value = self._take(key, default)
        if value is None:
            return low
        if not _is_number(value) or not low <= value <= high:
            self.fault(key, _shown(value), f"give a number from {low:g} to {high:g}")
            return low
        return float(value)

    def whole(self, key: str, default: int, low: int, high: int) -> int:
        """A whole number in [low, high]."""
        value = self._take(key, default)
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            self.fault(key, _shown(value), f"give a whole number from {low} to {high}")
            return low
        return value

    def text(self, key: str, default: str) -> str:
        """A string."""
        value = self._take(key, default)
        if not isinstance(value, str):
            self.fault(key, _shown(value), "give a text in quotes")
            return default
        return value

    def vector(self, key: str, length: int, largest: float) -> Vector:
        """`length` finite numbers, none beyond ±largest; the key must be there."""
        value = self._take(key, None)
        if value is None:
            return np.zeros(length)
        good = (
            isinstance(value, list)
            and len(value) == length
            and all(_is_number(part) and -largest <= part <= largest for part in value)
        )
        if not good:
            self.fault(key, _shown(value), f"give [{length} numbers] within ±{largest:g}")
            return np.zeros(length)
        return np.array(value, dtype=np.float64)

    def table(self, key: str) -> Table:
        """A table within; an empty one when there is none."""
        value = self._take(key, {})
        if not isinstance(value, dict):
            self.fault(key, _shown(value), f"write a table, [{key}]")
            value = {}
        return self._within(key, value)

    def tables(self, key: str, most: int) -> Iterator[Table]:
        """The tables of a list [[key]], none when there is no list."""
        values = self._take(key, [])
        if not isinstance(values, list) or not all(isinstance(one, dict) for one in values):
            self.fault(key, "not a list of tables", f"write [[{key}]]")
            return
        if len(values) > most:
            self.fault(key, f"{len(values)} of them", f"at most {most}")
            return
        for number, value in enumerate(values, start=1):
            yield self._within(f"{key}[{number}]", value)

    def refuse_unknown(self) -> None:
        """Note every key that nobody asked for: a misspelt key must not be passed over."""
        for key in self._values:
            if key not in self._known:
                self.fault(key, "unknown key", f"known are {', '.join(sorted(self._known))}")

    def _take(self, key: str, default: Any) -> Any:
        self._known.add(key)
        if key not in self._values and default is None:
            self.fault(key, "missing")
        return self._values.get(key, default)

    def _within(self, name: str, values: Mapping[str, Any]) -> Table:
        path = f"{self._path}.{name}" if self._path else name
        return Table(values, self._source, path, self._faults)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
