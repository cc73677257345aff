"""How often topics are written that would otherwise swell the log."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Rates:
    """Messages a second, at most."""

    depth: float = 2.0  # 848x480: 0.8 MB each before compression
    cells: float = 2.0
    gps: float = 5.0
    battery: float = 1.0


class Pace:
    """Lets through at most so many a second, evenly, by the records' own times."""

    def __init__(self, rate: float) -> None:
        self._period = 1.0 / rate
        self._due: float | None = None

    def due(self, time: float) -> bool:
        """Whether one of this time is wanted; asking counts as taking it."""
        due = time if self._due is None else self._due
        if time < due:
            return False
        self._due = max(due + self._period, time)
        return True
