"""Finding a flight's avoidances."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Array
from orchard_cli.model.flown import FlownLog
from orchard_cli.model.mission import Mission

from .figures import Avoidance, Clearances, Unknown
from .lines import Line, planned, spline_points, trajectory_points
from .route import Route

BEGIN = 0.1  # m of commanded offset at which an avoidance begins and ends
COUNTS = 0.3  # m: smaller detours are no avoidance
PAUSE = 2.0  # s: detours closer together are one
BEFORE = 1.0  # s before an avoidance whose mean height its altitude drop is taken from


def avoidances(
    log: FlownLog, mission: Mission, route: Route, clearances: Clearances | Unknown
) -> tuple[Avoidance, ...]:
    """The stretches of the route where the vehicle was told to leave the mission's path.

    Told: the commanded position stands more than BEGIN from the mission's own trajectory, and
    somewhere more than COUNTS. A log without commands is judged by the flown position, which
    must stand more than COUNTS from the global spline.
    """
    times = log.commands.times
    inside = (times >= route.start) & (times <= route.end)
    if inside.any():
        path = mission.trajectory
        own = Line(trajectory_points(path, path.start, path.end))
        offset = own.offset(log.commands.positions_site[inside]).distance
        spans = _spans(times[inside], offset, BEGIN)
    else:
        offset = Line(spline_points(mission.spline)).offset(route.track.positions_site).distance
        spans = _spans(route.track.times, offset, COUNTS)
    found = (_avoidance(start, end, mission, route, clearances) for start, end in spans)
    return tuple(one for one in found if one is not None)


def _spans(times: Array, offset: Array, threshold: float) -> list[tuple[float, float]]:
    away = np.flatnonzero(offset > threshold)
    if not len(away):
        return []
    breaks = np.flatnonzero(np.diff(times[away]) > PAUSE) + 1
    spans = [part for part in np.split(away, breaks) if offset[part].max() > COUNTS]
    return [(float(times[part[0]]), float(times[part[-1]])) for part in spans]


def _avoidance(
    start: float, end: float, mission: Mission, route: Route, clearances: Clearances | Unknown
) -> Avoidance | None:
    track = route.track.between(start, end)
    if not len(track.times):
        return None
    offset = planned(mission).offset(track.positions_site).distance
    peak = int(offset.argmax())
    before = route.track.between(start - BEFORE, start).positions_site[:, 2]
    lowest = track.positions_site[:, 2].min()
    return Avoidance(
        start=start,
        end=end,
        peak_m=float(offset[peak]),
        peak_site=track.positions_site[peak],
        altitude_drop_m=max(0.0, float(before.mean() - lowest)) if len(before) else 0.0,
        clearance_min_m=nearest(clearances, start, end),
    )


def nearest(
    clearances: Clearances | Unknown, start: float = -np.inf, end: float = np.inf
) -> float | Unknown:
    """Smallest distance to an obstacle within a time, m."""
    if isinstance(clearances, Unknown):
        return clearances
    inside = (clearances.times >= start) & (clearances.times <= end)
    found = clearances.obstacles[inside]
    if not len(found):
        return Unknown("no positions in this time")
    if not np.isfinite(found).any():
        return Unknown("there is no obstacle in the world")
    return float(found.min())
