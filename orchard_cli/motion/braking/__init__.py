"""Coming to rest along a trajectory."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Points
from orchard_cli.model.trajectory import DEGREE, Trajectory

from . import _kernels

_LEVELS = 4  # decelerations tried between gentle and the limit
_LONGEST = 60.0  # s of braking


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
    slowed = slowed_to(trajectory, first_knot(trajectory, start), 0.0, deceleration)
    if slowed is None:
        return trajectory
    return Trajectory(trajectory.start, trajectory.interval, slowed)


def brake_within(
    trajectory: Trajectory, start: float, room: float, gentle: float, limit: float
) -> Brake:
    """Brake as late as the `room` (m of path after `start`) allows, as gently as it allows.

    Decelerations from `gentle` to `limit` m/s² are tried. When even the hardest does not fit,
    it is returned with `fits` False.
    """
    knot, control = first_knot(trajectory, start), trajectory.control_points_site
    phase = (start - trajectory.start) / trajectory.interval
    out = _room(trajectory)
    for deceleration in np.linspace(gentle, limit, _LEVELS):
        most = float(deceleration) * trajectory.interval**2
        chosen, count = _kernels.latest(control, knot, phase, room, most, out)
        if chosen >= 0 and count < 0:
            return Brake(trajectory, True)
        if chosen >= 0:
            points = np.concatenate([control[: chosen + DEGREE], out[:count]])
            return Brake(Trajectory(trajectory.start, trajectory.interval, points), True)
    return Brake(brake(trajectory, start, limit), False)


def slowed_to(
    trajectory: Trajectory, knot: int, speed: float, deceleration: float
) -> Points | None:
    """Control points (n, 3): up to a knot as they are, then slower to `speed` m/s or to rest.

    None when the trajectory comes to rest sooner by itself.
    """
    control, interval = trajectory.control_points_site, trajectory.interval
    out = _room(trajectory)
    count = _kernels.slow(control, knot, deceleration * interval**2, speed * interval, out)
    return None if count < 0 else np.concatenate([control[: knot + DEGREE], out[:count]])


def first_knot(trajectory: Trajectory, time: float) -> int:
    """Index of the first knot at or after `time`, clipped to the trajectory.

    The curve up to knot k is made by control points 0 to k + 2 alone.
    """
    phase = (time - trajectory.start) / trajectory.interval
    return min(max(math.ceil(phase - 1e-9), 0), len(trajectory.control_points_site) - DEGREE)


def _room(trajectory: Trajectory) -> Points:
    return np.empty((math.ceil(_LONGEST / trajectory.interval), DEGREE))
