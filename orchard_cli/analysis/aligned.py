"""Flights of one route, aligned by place: where they were, not when."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array

from .along import places
from .figures import Avoidance
from .flight import Flight

SAME = 6.0  # m along the route: avoidances nearer than this are of the same obstacle

TRIED = 20_000  # samples of a flight whose place is looked for; in between it is even


@dataclass(frozen=True, slots=True, eq=False)
class Met:
    """One place where at least one flight turned aside, and what each did there."""

    place_m: float  # along the planned route
    avoidances: tuple[Avoidance | None, ...]  # by flight; None: it did not turn there


def on_route(flight: Flight, times: Array) -> Array:
    """Which times lie between the first and the last waypoint; all of them if it has no route."""
    start, end = flight.metrics.start, flight.metrics.end
    if start is None or end is None:
        return np.ones(len(times), dtype=bool)
    return np.asarray((times >= start) & (times <= end))


def place_at(flight: Flight, times: Array) -> Array:
    """(n,) s, flight clock -> (n,) m along the planned route."""
    track = flight.log.odometry
    route = on_route(flight, track.times)
    step = max(1, np.count_nonzero(route) // TRIED)
    along = places(flight.mission.waypoints_site, track.positions_site[route][::step])
    return np.interp(times, track.times[route][::step], along)


def met(flights: Sequence[Flight]) -> tuple[Met, ...]:
    """Avoidances side by side, in the order of the route."""
    found = []
    for i, flight in enumerate(flights):
        ends = [(one.start, one.end) for one in flight.metrics.avoidances]
        middles = (
            place_at(flight, np.array(ends).reshape(-1, 2).ravel()).reshape(-1, 2).mean(axis=1)
        )
        found += [
            (float(middle), i, one)
            for middle, one in zip(middles, flight.metrics.avoidances, strict=True)
        ]
    rows: list[tuple[list[float], list[Avoidance | None]]] = []
    for place, i, one in sorted(found, key=lambda each: each[0]):
        if not rows or rows[-1][1][i] is not None or place - rows[-1][0][0] > SAME:
            rows.append(([], [None] * len(flights)))
        rows[-1][0].append(place)
        rows[-1][1][i] = one
    return tuple(Met(float(np.mean(at)), tuple(ones)) for at, ones in rows)
