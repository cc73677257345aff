"""Waypoints that a way round does not come to any more."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Array
from orchard_cli.model.mission import WAYPOINT_PASSED, Mission
from orchard_cli.model.trajectory import Trajectory

STEP = 0.25  # s between the places looked at


def skipped(mission: Mission, before: Trajectory, after: Trajectory, now: float) -> tuple[int, ...]:
    """Numbers (from 1) of the waypoints that `before` would have passed, and `after` will not."""
    was, will = (_passes(mission, way, now) for way in (before, after))
    return tuple(int(k) + 1 for k in np.flatnonzero(was > will))


def _passes(mission: Mission, way: Trajectory, now: float) -> Array:
    """(k,) 1 where a waypoint comes within WAYPOINT_PASSED m of what is left of a way, else 0."""
    places = way.sample(np.arange(now, max(way.end, now) + STEP, STEP))[0][:, :2]
    waypoints = np.asarray(mission.waypoints_site)[:, None, :2]
    apart = np.linalg.norm(places - waypoints, axis=2).min(axis=1)
    return np.asarray(apart <= WAYPOINT_PASSED, dtype=np.float64)
