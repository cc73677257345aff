"""What analysis hands out: figures with units, honest gaps, and the avoidances of a flight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from orchard_cli.model.arrays import Array, Vector
from orchard_cli.model.flown import Contact


@dataclass(frozen=True, slots=True)
class Unknown:
    """A metric that cannot be computed, and why. It is never 0."""

    why: str


Figure = float | Unknown


@dataclass(frozen=True, slots=True, eq=False)
class Clearances:
    """Distances from the airframe's centre to the nearest surface, along a flight.

    Measured by the caller against the simulated world; a kind that the world has none of is
    infinite.
    """

    times: Array  # (n,) s, flight clock
    obstacles: Array  # (n,) m, to poles, wires, boxes and people
    trees: Array  # (n,) m, to trunks and canopies


@dataclass(frozen=True, slots=True, eq=False)
class Avoidance:
    """One detour from the mission's path."""

    start: float  # s, flight clock
    end: float  # s
    peak_m: float  # largest horizontal distance to the planned Π
    peak_site: Vector  # (3,) m, where that was
    altitude_drop_m: float  # mean height just before minus the lowest in it; at least 0
    clearance_min_m: Figure


@dataclass(frozen=True, slots=True, eq=False)
class Metrics:
    """Every metric of docs/metrics.md by its name, in the order of that page."""

    figures: Mapping[str, Figure]
    avoidances: tuple[Avoidance, ...]
    start: float | None  # s, flight clock: first waypoint reached
    end: float | None  # s: last waypoint reached, or where the route was given up
    notes: tuple[str, ...]  # what a reader of the figures must know
    contacts: tuple[Contact, ...] = ()  # what was touched, as far as it is known
