"""The flown trajectory is the reference with spans of its control points replaced.

A replacement may have more points than it replaces: what follows is then the reference, a whole
number of intervals later. Counted from the end, its control points are still the reference's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Points
from orchard_cli.model.trajectory import DEGREE, Trajectory

from .braking import first_knot

_FLOWN = 2.0  # s: no commit time lies further ahead than this
_CUT = 4.0  # s by which a detour may be shorter than what it replaces, when it cuts a corner


@dataclass(frozen=True, slots=True, eq=False)
class Head:
    """What of a trajectory is kept: all that is flown up to a knot."""

    start: float  # s
    interval: float  # s
    control_points_site: Points  # (k + 3, 3): knot k is where a change may begin

    @property
    def begin(self) -> float:
        """Time of the knot, s."""
        return self.start + (len(self.control_points_site) - DEGREE) * self.interval


def head_at(active: Trajectory, commit: float, interval: float) -> Head:
    """The active trajectory up to its first knot at or after `commit`.

    Past its end it stands still. Soon after, the head goes on standing there; later, when all of
    it has been flown for certain, the head begins anew at `commit`, with knots `interval` apart.
    """
    points = active.control_points_site
    if commit > active.end + _FLOWN:
        return Head(commit, interval, np.repeat(points[-1:], DEGREE, axis=0))
    if commit > active.end:
        more = int(np.ceil((commit - active.end) / active.interval))
        return Head(active.start, active.interval, np.vstack([points, *[points[-1:]] * more]))
    return Head(active.start, active.interval, points[: first_knot(active, commit) + DEGREE])


def shared_tail(active: Trajectory, reference: Trajectory) -> int:
    """How many control points at the end of both are the same."""
    a, r = active.control_points_site, reference.control_points_site
    n = min(len(a), len(r))
    differs = (a[len(a) - n :] != r[len(r) - n :]).any(axis=1)
    where = np.flatnonzero(differs)
    return n if len(where) == 0 else int(n - 1 - where[-1])


def splice(head: Head, free: Points, reference: Trajectory, rejoin: int) -> Trajectory:
    """Head, then the free control points (f, 3), then the reference from its knot `rejoin` on.

    Raises ValueError when the two have different intervals: their curves would not be kept.
    """
    if abs(head.interval - reference.interval) > 1e-9:
        raise ValueError("head and reference have different knot intervals")
    tail = reference.control_points_site[rejoin:]
    control = np.concatenate([head.control_points_site, free, tail])
    return Trajectory(head.start, head.interval, control)


def knots_of(control_points: Points) -> Points:
    """Where the curve is at its knots: (n, 3) control points -> (n - 2, 3) m."""
    c = control_points
    return (c[:-2] + 4 * c[1:-1] + c[2:]) / 6


def nearest_knot(reference: Trajectory, point: Points, low: int, high: int) -> int:
    """Index of the reference's knot nearest to a point (3,), among those in [low, high]."""
    last = len(reference.control_points_site) - DEGREE
    low = min(max(low, 0), last)
    high = min(max(high, low), last)
    knots = knots_of(reference.control_points_site[low : high + DEGREE])
    return low + int(np.argmin(np.linalg.norm(knots[:, :2] - point[:2], axis=1)))


def counterpart(
    active: Trajectory, reference: Trajectory, tail: int, knot: int, point: Points
) -> int:
    """The reference's knot that belongs to a knot of the active one, at `point` (3,).

    Where both are the same (the last `tail` points) it is known exactly; inside a detour it is
    the nearest one between where it would be without this detour's delay, and the rejoin point.
    """
    delay = len(active.control_points_site) - len(reference.control_points_site)
    first_shared = len(active.control_points_site) - tail
    if knot >= first_shared:
        return knot - delay
    cut = round(_CUT / reference.interval)
    return nearest_knot(reference, point, knot - max(delay, 0) - cut, first_shared - delay)
