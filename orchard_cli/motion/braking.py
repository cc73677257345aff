"""Coming to rest along a trajectory."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.trajectory import DEGREE, Trajectory

_SHARES = np.linspace(1.0, 0.0, 9)  # of the braking asked for, where a bend needs the rest


@dataclass(frozen=True, slots=True, eq=False)
class Brake:
    """A trajectory that comes to rest, and whether it does so within the room given."""

    trajectory: Trajectory
    fits: bool


def brake(trajectory: Trajectory, start: float, deceleration: float) -> Trajectory:
    """The same curve up to the first knot at or after `start`, then slower and slower to rest.

    It stays on the control polygon, joins with continuous acceleration, and slows by at most
    `deceleration` m/s², less where the bend itself needs some of it. A trajectory that comes to
    rest sooner by itself is returned as it is.
    """
    knot = first_knot(trajectory, start)
    return _brake_at(trajectory, knot, deceleration) or trajectory


def brake_within(
    trajectory: Trajectory, start: float, room: float, gentle: float, limit: float
) -> Brake:
    """Brake as late as the `room` (m of path after `start`) allows, as gently as it allows.

    Decelerations from `gentle` to `limit` m/s² are tried. When even the hardest does not fit,
    it is returned with `fits` False.
    """
    knot = first_knot(trajectory, start)
    lengths = _lengths(trajectory.control_points_site)
    here = _travelled(trajectory, start, lengths)
    if lengths[-1] - here <= room:
        return Brake(trajectory, True)
    for deceleration in np.linspace(gentle, limit, 4):
        latest: Trajectory | None = None
        for k in range(knot, len(lengths) - DEGREE):
            if lengths[k + 2] - here > room:
                break
            braked = _brake_at(trajectory, k, float(deceleration))
            if _rest(braked or trajectory) - here > room:
                break
            latest = braked or trajectory
            if braked is None:
                break
        if latest is not None:
            return Brake(latest, True)
    return Brake(_brake_at(trajectory, knot, limit) or trajectory, False)


def first_knot(trajectory: Trajectory, time: float) -> int:
    """Index of the first knot at or after `time`, clipped to the trajectory.

    The curve up to knot k is made by control points 0 to k + 2 alone.
    """
    phase = (time - trajectory.start) / trajectory.interval
    return min(max(math.ceil(phase - 1e-9), 0), len(trajectory.control_points_site) - DEGREE)


def _brake_at(trajectory: Trajectory, knot: int, deceleration: float) -> Trajectory | None:
    """Brake from a knot on; None when the trajectory comes to rest sooner by itself."""
    control = trajectory.control_points_site
    way = control[knot + 2 :]
    if len(way) < 2:
        return None
    lengths = _lengths(way)
    steps = np.diff(lengths, append=lengths[-1])
    most = deceleration * trajectory.interval**2  # m, by which two steps may differ
    points = [control[knot + 1], control[knot + 2]]
    step, at = float(np.linalg.norm(points[1] - points[0])), 0.0
    while step > 0:
        own = float(np.interp(at, lengths, steps))
        best = (math.inf, 0.0, points[-1])
        for share in _SHARES:
            wanted = max(min(step - share * most, own), step - most, 0.0)
            point = _along(way, lengths, at + wanted)
            change = float(np.linalg.norm(point - 2 * points[-1] + points[-2]))
            if change < best[0]:
                best = (change, wanted, point)
            if change <= most * (1 + 1e-9):
                break
        step, point = best[1], best[2]
        at += step
        if at >= lengths[-1]:
            return None
        points.append(point)
    points.append(points[-1])
    return Trajectory(
        trajectory.start, trajectory.interval, np.vstack([control[: knot + 3], points[2:]])
    )


def _lengths(points: Points) -> Array:
    """Path length from the first of the points to each (n,), m."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def _along(way: Points, lengths: Array, at: float) -> Array:
    return np.array([np.interp(at, lengths, way[:, c]) for c in range(3)])


def _travelled(trajectory: Trajectory, time: float, lengths: Array) -> float:
    """Path length along the control polygon up to `time`: knot k lies beside point k + 1."""
    phase = (time - trajectory.start) / trajectory.interval + 1
    return float(np.interp(phase, np.arange(len(lengths)), lengths))


def _rest(trajectory: Trajectory) -> float:
    return float(_lengths(trajectory.control_points_site)[-1])
