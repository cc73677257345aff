"""Leaving the active trajectory without a step, whatever the knot interval of what follows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Points, Vector
from orchard_cli.model.trajectory import DEGREE, MotionState, Trajectory

_NEAR = 1e-6  # s: knots so near to an instant are at it


@dataclass(frozen=True, slots=True, eq=False)
class Join:
    """The kept beginning of a new trajectory.

    Its curve equals the active one from now to the commit time exactly, and the last three
    control points fix position, velocity and acceleration at `time`.
    """

    time: float  # s, where the new curve begins
    interval: float  # s between its knots
    points_site: Points  # (m, 3), control points centred from time - (m - 2) interval on

    @property
    def start(self) -> float:
        """Where a trajectory that begins with these points starts, s."""
        return self.time - (len(self.points_site) - DEGREE) * self.interval


@dataclass(frozen=True, slots=True, eq=False)
class _Piece:
    """One cubic of a trajectory: its state at a time, and its constant jerk."""

    state: MotionState
    jerk: Vector

    def control_point(self, centre: float, interval: float) -> Vector:
        """Of a spline that is this cubic around `centre`: p - interval² / 6 a, exact for cubics."""
        s, t = self.state, centre - self.state.time
        position = s.position_site + t * (
            s.velocity_site + t * (s.acceleration_site / 2 + t * self.jerk / 6)
        )
        point: Vector = position - interval**2 / 6 * (s.acceleration_site + t * self.jerk)
        return point


def join_at(active: Trajectory, now: float, commit: float, interval: float) -> Join:
    """Leave the active trajectory at the commit time, or up to an interval later.

    Knots lie where the active trajectory has one between `now` and `commit`. Where it has more
    than one, its own interval is kept instead of the one asked for; where it has one too early for
    that to reach the commit time, the interval is the longer for it.
    """
    inside = _knots(active, now, commit)
    if len(inside) > 1:
        interval = active.interval
    if len(inside) == 0:
        piece = _piece(active, (now + commit) / 2)
        leads = max(1, int(np.ceil((commit - now) / interval + _NEAR)))
        centres = commit + interval * np.arange(-leads - 1, 2)
        points = [piece.control_point(float(c), interval) for c in centres]
        return Join(commit, interval, np.array(points))
    interval = max(interval, commit - inside[-1])  # never before the commit time
    leads = max(1, int(np.ceil((inside[0] - now) / interval + _NEAR)))
    before = _piece(active, inside[0] - _NEAR)
    points = [
        before.control_point(inside[0] + k * interval, interval) for k in range(-leads - 1, 2)
    ]
    points += [
        _piece(active, knot + _NEAR).control_point(knot + 2 * interval, interval) for knot in inside
    ]
    return Join(inside[-1] + interval, interval, np.array(points))


def _knots(active: Trajectory, begin: float, end: float) -> list[float]:
    """The knots of a trajectory strictly between two times; none before its start or after."""
    first = max(int(np.floor((begin + _NEAR - active.start) / active.interval)) + 1, 0)
    last = min(
        int(np.ceil((end - _NEAR - active.start) / active.interval)) - 1,
        len(active.control_points_site) - DEGREE,
    )
    return [active.start + k * active.interval for k in range(first, last + 1)]


def _piece(active: Trajectory, time: float) -> _Piece:
    state = active.at(time)
    if not active.start <= time <= active.end:
        return _Piece(state, np.zeros(3))
    q = active.control_points_site[active.segment(time) :][: DEGREE + 1]
    jerk = (q[3] - 3 * q[2] + 3 * q[1] - q[0]) / active.interval**3
    return _Piece(state, jerk)
