"""The same mission waypoint by waypoint: straight legs, at rest at the end of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from orchard_cli.errors import InputError
from orchard_cli.model.arrays import Points
from orchard_cli.model.mission import Mission, Segment
from orchard_cli.model.trajectory import DEGREE, Trajectory
from orchard_cli.motion.timing import PathLimits, time_path

from . import checks, energy

_SAME = 1e-3  # m: ends so near are one
_AT_REST = 1e-9  # m between control points


def with_stops(mission: Mission) -> Mission:
    """Fly the Π itself, with a stop in every waypoint, instead of its rounded curve.

    Raises InputError where that cannot be flown, with every fault.
    """
    planned, interval = mission.trajectory.control_points_site, mission.trajectory.interval
    waypoints = np.asarray(mission.waypoints_site)
    ends = np.vstack([planned[:1], waypoints, planned[-1:]])
    legs, reached = planned[:1].repeat(DEGREE, axis=0), [0.0]
    for start, end in pairwise(ends):
        if np.linalg.norm(end - start) > _SAME:
            legs = np.vstack([legs, _leg(start, end, mission, interval)])
        reached.append((len(legs) - DEGREE) * interval)
    trajectory = Trajectory(0.0, interval, legs)
    found = replace(
        mission,
        trajectory=trajectory,
        segments=tuple(_segments(mission, reached[1:-1], trajectory.end)),
        energy_share=energy.share_over(
            mission.orchard, planned[[0, -1]], trajectory.end, mission.limits
        ),
    )
    if faults := checks.check(found):
        raise InputError(faults)
    return found


def _leg(start: Points, end: Points, mission: Mission, interval: float) -> Points:
    """Control points (n, 3) from rest to rest, without the first three, which are at the start."""
    limits = PathLimits.planned(mission.limits)
    points = time_path(np.stack([start, end]), limits, interval).trajectory.control_points_site
    moving = np.flatnonzero(np.linalg.norm(np.diff(points, axis=0), axis=1) > _AT_REST)
    between = points[moving[0] + 1 : moving[-1] + 1]
    return np.vstack([between, np.repeat(end[None], DEGREE, axis=0)])


def _segments(mission: Mission, reached: list[float], end: float) -> Iterator[Segment]:
    """The mission's, at the new times of their waypoints."""
    begin = 0.0
    for segment in mission.segments[:-1]:
        until = reached[segment.until]
        yield replace(segment, start=begin, end=until)
        begin = until
    yield replace(mission.segments[-1], start=begin, end=end)
