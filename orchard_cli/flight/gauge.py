"""How full the tank is: what was in it at take-off, less what the pump has taken."""

from __future__ import annotations

from collections.abc import Callable

from orchard_cli.model.tank import Load

LONGEST = 0.5  # s between two looks: what lasts longer is a gap, in which nobody ran the pump


class Gauge:
    """Switches the pump, on changes only, and counts the liquid. Without a tank it does nothing."""

    def __init__(self, load: Load | None, pump: Callable[[bool], None]) -> None:
        self.load = load
        self._pump = pump
        self._full = load
        self._on = False
        self._since = 0.0

    @property
    def empty(self) -> bool:
        """Whether there is nothing left to spray; a vehicle without a tank is not asked."""
        return self.load is not None and self.load.empty

    @property
    def used(self) -> float | None:
        """l sprayed since take-off; None without a tank."""
        if self.load is None or self._full is None:
            return None
        return self.load.vehicle.litres(self._full.level - self.load.level)

    def run(self, on: bool, now: float) -> None:
        """The pump shall run, or not, from now on."""
        if self.load is None:
            return
        if self._on:
            self.load = self.load.after(min(now - self._since, LONGEST))
        self._since = now
        if on is not self._on:
            self._on = on
            self._pump(on)
