"""One measured flight: what tables, pictures, pages and exports are made from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from orchard_cli.model.flown import FlownLog
from orchard_cli.model.mission import Mission
from orchard_cli.model.world import World

from .figures import Clearances, Metrics, Unknown
from .verdicts import Verdict


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """One log, measured against its mission."""

    log: FlownLog
    mission: Mission
    world: World | None  # None: a real flight
    clearances: Clearances | Unknown
    metrics: Metrics
    verdicts: tuple[Verdict, ...]

    @property
    def begin(self) -> float:
        """Time 0 of its curves: the first waypoint; if never reached, the log's beginning."""
        if self.metrics.start is not None:
            return self.metrics.start
        times = self.log.odometry.times
        return float(times[0]) if len(times) else 0.0


def names(flights: Sequence[Flight]) -> list[str]:
    """A short name for each flight: its system, numbered where systems repeat."""
    systems = [flight.log.system for flight in flights]
    return [
        system if systems.count(system) == 1 else f"{system} {systems[:i].count(system) + 1}"
        for i, system in enumerate(systems)
    ]
