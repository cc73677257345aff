"""From when to when the route was flown: the first waypoint reached to the last."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.model.flown import FlownLog, Track
from orchard_cli.model.mission import Mission

from .figures import Unknown

SLACK = 0.05  # m: as good as the closest approach


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """The flown route."""

    track: Track  # odometry from `start` to `end`
    start: float  # s, flight clock
    end: float  # s
    completed: bool  # False: the last waypoint was not reached; `end` is where the route ended


def reach(mission: Mission) -> float:
    """m: a waypoint is reached within this distance, since the planned curve cuts corners."""
    return max(0.5, mission.corner_cut + 0.3)


def route(log: FlownLog, mission: Mission) -> Route | Unknown:
    """The part of the flight that distance, time and deviations are measured over.

    It starts when the vehicle leaves the closest approach of its first visit to the first
    waypoint, and ends when it comes to the closest approach of its last visit to the last one.
    """
    track = log.odometry
    if len(track.times) < 2:
        return Unknown("the log holds no odometry")
    first, last = mission.waypoints_site[0], mission.waypoints_site[-1]
    begun = _visit(track, first, reach(mission), newest=False)
    if begun is None:
        return Unknown("the first waypoint was not reached")
    ended = _visit(track, last, reach(mission), newest=True)
    completed = ended is not None and ended > begun
    stop = ended if completed and ended is not None else _given_up(log, track)
    if stop <= begun:
        return Unknown("the route was not flown")
    start, end = float(track.times[begun]), float(track.times[stop])
    return Route(track.between(start, end), start, end, completed)


def _visit(track: Track, waypoint: Vector, radius: float, newest: bool) -> int | None:
    """Sample at which the first visit is left, or the newest begins; None: never visited."""
    distance = np.linalg.norm(track.positions_site - waypoint, axis=1)
    inside = np.flatnonzero(distance <= radius)
    if not len(inside):
        return None
    visits = np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1)
    visit = visits[-1] if newest else visits[0]
    close = visit[distance[visit] <= distance[visit].min() + SLACK]
    return int(close[0] if newest else close[-1])


def _given_up(log: FlownLog, track: Track) -> int:
    """Sample at which the flight last was on its route, by /safety; else the last one."""
    on_route = [s.time for s in log.safety if s.phase in ("route", "avoidance")]
    end = on_route[-1] if on_route else float(track.times[-1])
    return int(np.searchsorted(track.times, end, side="right")) - 1
