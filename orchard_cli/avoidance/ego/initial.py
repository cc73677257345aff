"""First guesses of a curve: where its knots lie before anything pushes them off obstacles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.trajectory import MotionState, Trajectory

FEWEST = 6  # segments of a curve
_LONGEST = 0.6  # m between neighbouring knots
_DENSER = 1.5
_STEP = 0.1  # s, of samples by which a curve's length is measured
_SIDEWAYS, _VERTICAL = 0.4, 0.2  # of the distance: how far a random midpoint may lie off
_POWERS = np.arange(6)


@dataclass(frozen=True, slots=True)
class Pace:
    """How fast a curve is meant to be flown."""

    speed: float  # m/s
    acceleration: float  # m/s²
    spacing: float  # m between control points
    interval: float  # s between knots

    def duration(self, distance: float) -> float:
        """Seconds for a distance: speed up, cruise, slow down; all of it short when it is short."""
        v, a = self.speed, self.acceleration
        if distance < v * v / a:
            return float(np.sqrt(distance / a))
        return (distance - v * v / a) / v + 2 * v / a


@dataclass(frozen=True, slots=True, eq=False)
class Polynomial:
    """Quintics one after the other, each of the same duration."""

    coefficients: Array  # (m, 6, 3), of the time since each one's begin
    duration: float  # s, of each

    def at(self, times: Array) -> Points:
        """Positions (n, 3) at times (n,) since the begin of the first."""
        k = np.clip((times // self.duration).astype(int), 0, len(self.coefficients) - 1)
        local = (times - k * self.duration)[:, None] ** _POWERS
        places: Points = np.einsum("np,npc->nc", local, self.coefficients[k])
        return places


def quintic(begin: MotionState, end: MotionState, duration: float) -> Polynomial:
    """The quintic between two full states."""
    t = duration
    p0, v0, a0 = begin.position_site, begin.velocity_site, begin.acceleration_site
    dp = end.position_site - p0 - v0 * t - a0 * t * t / 2
    dv = (end.velocity_site - v0 - a0 * t) * t
    da = (end.acceleration_site - a0) * t * t
    rows = [
        p0, v0, a0 / 2,
        (10 * dp - 4 * dv + da / 2) / t**3,
        (-15 * dp + 7 * dv - da) / t**4,
        (6 * dp - 3 * dv + da / 2) / t**5,
    ]  # fmt: skip
    return Polynomial(np.array(rows)[None], t)


def through(begin: MotionState, middle: Vector, end: MotionState, duration: float) -> Polynomial:
    """Least jerk from state to state through a point (3,) at half time: two quintics."""
    t = duration / 2
    matrix, right = np.zeros((12, 12)), np.zeros((12, 3))
    for n in range(3):
        matrix[n, :6] = _derivative(n, 0.0)
        matrix[3 + n, 6:] = _derivative(n, t)
    matrix[6, :6], matrix[7, 6:] = _derivative(0, t), _derivative(0, 0.0)
    for n in range(1, 5):
        matrix[7 + n, :6], matrix[7 + n, 6:] = _derivative(n, t), -_derivative(n, 0.0)
    right[:3] = begin.position_site, begin.velocity_site, begin.acceleration_site
    right[3:6] = end.position_site, end.velocity_site, end.acceleration_site
    right[6] = right[7] = middle
    solved = np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
    return Polynomial(solved.reshape(2, 6, 3), t)


def _derivative(order: int, t: float) -> Array:
    """(6,): the n-th derivative of t^0 to t^5."""
    row = np.zeros(6)
    for k in range(order, 6):
        row[k] = np.prod(np.arange(k - order + 1, k + 1)) * t ** (k - order)
    return row


def random_middle(begin: Vector, end: Vector, failures: int, random: np.random.Generator) -> Vector:
    """A point between two (3,), off to the side and up or down, further after every failure."""
    way = end - begin
    distance = float(np.linalg.norm(way))
    side = np.array([-way[1], way[0], 0.0]) / max(float(np.hypot(way[0], way[1])), 1e-6)
    spread = distance * min(1.0 + 0.25 * failures, 2.0)
    off, up = random.uniform(-1, 1, 2) * spread * (_SIDEWAYS, _VERTICAL)
    middle: Vector = (begin + end) / 2 + off * side + np.array([0.0, 0.0, up])
    return middle


def sampling(curve: Polynomial, pace: Pace) -> tuple[int, float]:
    """How many segments a polynomial is cut into, and the interval that this makes, s."""
    duration = curve.duration * len(curve.coefficients)
    count = max(1, round(duration / pace.interval))
    while True:
        places = curve.at(np.linspace(0.0, duration, count + 1))
        longest = np.linalg.norm(np.diff(places, axis=0), axis=1).max()
        if count >= FEWEST and (longest <= _LONGEST or count > 100):
            return count, duration / count
        count = max(int(np.ceil(count * _DENSER)), count + 1)


def continued(
    active: Trajectory, begin: float, end: float, target: MotionState, pace: Pace
) -> Points:
    """Knots (n + 1, 3): the rest of a curve and a quintic from its end on, evenly spaced."""
    last = active.at(end)
    away = float(np.linalg.norm(target.position_site - last.position_site))
    kept = active.sample(np.linspace(begin, end, max(2, int((end - begin) / _STEP))))[0]
    if away > 1e-3:
        tail = quintic(last, target, pace.duration(away))
        times = np.linspace(0.0, tail.duration, max(3, int(tail.duration / _STEP)))
        kept = np.concatenate([kept, tail.at(times[1:])])
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(kept, axis=0), axis=1))])
    count = max(FEWEST, round(float(lengths[-1]) / pace.spacing))
    even = np.linspace(0.0, lengths[-1], count + 1)
    return np.column_stack([np.interp(even, lengths, axis) for axis in kept.T])
