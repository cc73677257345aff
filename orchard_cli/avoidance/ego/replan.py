"""One replan: from a first guess to a checked curve, joined to what is flown and to the route."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.mission import Limits
from orchard_cli.model.trajectory import DEGREE, Trajectory
from orchard_cli.motion.join import Join, join_at

from . import _kernels
from .initial import Pace, Polynomial, continued, quintic, random_middle, sampling, through
from .obstacles import Obstacles
from .route import Target, onward, strays
from .settings import EgoSettings

ON_ROUTE = 0.2  # m from the reference within which the vehicle counts as being on it
_WHY = {
    _kernels.NO_WAY: "no way round was found",
    _kernels.AT_ONCE: "an obstacle is where the new curve would begin",
    _kernels.STILL_HIT: "the curve cannot be pushed off an obstacle",
}


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A trajectory, and which part of it is the local curve; the rest is the reference."""

    trajectory: Trajectory
    asked: float  # s, when it was planned
    begin: float  # s
    end: float  # s
    reached: float  # s on the reference's clock, of the local target
    rejoin: float = 0.0  # s, from when on it is on the reference
    touched: int = 0  # control points that were pushed off obstacles
    refined: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class NoCurve:
    """Why there is none."""

    why: str


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """What one replan works with."""

    now: float  # s
    commit: float  # s
    active: Trajectory
    reference: Trajectory
    target: Target
    obstacles: Obstacles
    pace: Pace


def task_pace(limits: Limits, settings: EgoSettings) -> Pace:
    """How fast curves are flown under a mission's limits."""
    return Pace(
        limits.speed,
        settings.acceleration or limits.acceleration,
        settings.spacing,
        settings.spacing / limits.speed * settings.haste,
    )


def from_previous(task: Task, end: float, settings: EgoSettings) -> Curve | NoCurve:
    """Begin with the rest of the curve being flown, which ends at `end`."""
    join = join_at(task.active, task.now, task.commit, task.pace.interval)
    if end <= join.time + join.interval:
        return from_rest(task, settings)
    knots = continued(task.active, join.time, end, task.target.state, task.pace)
    return _curve(task, join, knots, settings)


def from_rest(
    task: Task,
    settings: EgoSettings,
    failures: int = 0,
    random: np.random.Generator | None = None,
) -> Curve | NoCurve:
    """Begin with a quintic to the target; with `random`, through a random point on the way."""
    join = join_at(task.active, task.now, task.commit, task.pace.interval)
    end = task.target.state
    begin = task.active.at(join.time)
    middle = None
    if random is not None:
        middle = random_middle(begin.position_site, end.position_site, failures, random)

    def shape(join: Join, duration: float) -> Polynomial:
        begin = task.active.at(join.time)
        target = replace(end, acceleration_site=np.zeros(3))
        if middle is None:
            return quintic(begin, target, duration)
        return through(begin, middle, target, duration)

    away = float(np.linalg.norm(end.position_site - begin.position_site))
    if away < 1e-3:
        return NoCurve("the local target is where the vehicle is")
    count, interval = sampling(shape(join, task.pace.duration(away)), task.pace)
    join = join_at(task.active, task.now, task.commit, interval)
    duration = count * join.interval
    knots = shape(join, duration).at(np.linspace(0.0, duration, count + 1))
    return _curve(task, join, knots, settings)


def load_kernels(settings: EgoSettings) -> None:
    """Compile or load the kernels, also those that only few replans need: not in flight."""
    cells, frame = np.zeros((1, 1, 1), dtype=np.bool_), np.array([0.0, 0.0, 0.0, 0.1])
    limits, span = np.ones(3), np.zeros((9, 3))
    knots, tangents = _shape(span)
    _kernels.fit(span, knots)
    _kernels.rebound(
        span, 0.5, settings.weights, limits, cells, frame, settings.checked, np.zeros(9, np.int64)
    )
    _kernels.refine(
        span, 0.5, settings.refining, limits, cells, frame, settings.checked, knots, tangents
    )


def _curve(task: Task, join: Join, knots: Points, settings: EgoSettings) -> Curve | NoCurve:
    """Fit, rebound, and refine where it is too fast."""
    obstacles, limits = task.obstacles, _limits(task.pace, settings)
    span, rest = _span(task, join, knots)
    counts = np.zeros(len(span), dtype=np.int64)
    outcome = _kernels.rebound(
        span, join.interval, settings.weights, limits, obstacles.cells, obstacles.frame,
        settings.checked, counts,
    )  # fmt: skip
    if outcome != _kernels.FREE:
        return NoCurve(_WHY[outcome])
    excess = _excess(span, join.interval, limits)
    refined = excess > 1 + settings.tolerance
    if refined:
        knots, tangents = _shape(span)
        join = join_at(task.active, task.now, task.commit, join.interval * excess)
        span, rest = _span(task, join, knots)
        outcome = _kernels.refine(
            span, join.interval, settings.refining, limits, obstacles.cells, obstacles.frame,
            settings.checked, knots, tangents,
        )  # fmt: skip
        if outcome != _kernels.FREE:
            return NoCurve("slowed down, the curve touches an obstacle")
    return _joined(task, join, span, rest, int(np.count_nonzero(counts)), refined)


def _span(task: Task, join: Join, knots: Points) -> tuple[Points, Points]:
    """Control points of the curve fitted to knots (n + 1, 3), and those of what follows it."""
    rest = onward(task.reference, task.target, join.interval)
    span = np.empty((len(knots) + 2, 3))
    span[:DEGREE], span[-DEGREE:] = join.points_site[-DEGREE:], rest[:DEGREE]
    _kernels.fit(span, np.ascontiguousarray(knots))
    return span, rest[DEGREE:]


def _joined(
    task: Task, join: Join, span: Points, rest: Points, touched: int, refined: bool
) -> Curve:
    control = np.concatenate([join.points_site, span[DEGREE:], rest])
    end = join.time + (len(span) - DEGREE) * join.interval
    off = strays(_shape(span)[0], task.target.ahead_site, ON_ROUTE)
    rejoin = join.time + (off[-1] + 1) * join.interval if len(off) else -np.inf
    return Curve(
        Trajectory(join.start, join.interval, control), task.now, join.time, end, task.target.time,
        max(float(rejoin), float(np.nextafter(join.time, np.inf))), touched, refined,
    )  # fmt: skip


def _limits(pace: Pace, settings: EgoSettings) -> Array:
    return np.array([pace.speed, pace.acceleration, settings.distance])


def _excess(span: Points, interval: float, limits: Array) -> float:
    """By how much the curve must be stretched to keep its limits, axis by axis."""
    speed = float(np.abs(np.diff(span, axis=0)).max()) / interval
    bend = float(np.abs(np.diff(span, n=2, axis=0)).max()) / interval**2
    return max(speed / float(limits[0]), float(np.sqrt(bend / limits[1])))


def _shape(span: Points) -> tuple[Points, Points]:
    """Where the knots of a curve are (n - 2, 3), and which way it leads there: unit or zero."""
    knots = (span[:-2] + 4 * span[1:-1] + span[2:]) / 6
    ways = span[2:] - span[:-2]
    return knots, ways / np.maximum(np.linalg.norm(ways, axis=1), 1e-9)[:, None]
