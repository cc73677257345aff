"""The same curve with more control points: halving the knot interval of a cubic B-spline."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Points
from orchard_cli.model.trajectory import DEGREE, MotionState, Trajectory


def refined(trajectory: Trajectory, halvings: int) -> Trajectory:
    """The same curve with its knot interval halved `halvings` times."""
    control = halved(trajectory.control_points_site, halvings)
    return Trajectory(trajectory.start, trajectory.interval / 2**halvings, control)


def halved(control_points: Points, halvings: int) -> Points:
    """Control points (n, d) of the same curve with its knots halved, (2 n - 3, d) each time.

    Lane and Riesenfeld's rule: (1, 4, 6, 4, 1) / 8.
    """
    q = control_points
    for _ in range(halvings):
        finer = np.empty((2 * len(q) - DEGREE, q.shape[1]))
        finer[::2] = (q[:-1] + q[1:]) / 2
        finer[1::2] = (q[:-2] + 6 * q[1:-1] + q[2:]) / 8
        q = finer
    return q


def knot_state(control_points: Points, knot: int, interval: float) -> MotionState:
    """Position, velocity and acceleration of a curve at one of its knots; time from its start."""
    a, b, c = control_points[knot : knot + DEGREE]
    return MotionState(
        knot * interval,
        (a + 4 * b + c) / 6,
        (c - a) / (2 * interval),
        (a - 2 * b + c) / interval**2,
    )


def controls_of(state: MotionState, interval: float) -> Points:
    """The three control points (3, 3) that a curve with this state at a knot has there."""
    p, v, a = state.position_site, state.velocity_site * interval, state.acceleration_site
    a = a * interval**2
    return np.stack([p - v + a / 3, p - a / 6, p + v + a / 3])
