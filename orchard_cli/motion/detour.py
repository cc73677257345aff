"""One detour: a guide path, sampled, optimised twice, and checked (Liu 2024, §4.2 to §4.4).

Head and reference have fine knots, so that a detour may begin and end at almost any time; the
detour itself is optimised on knots `halvings` times as far apart, the paper's 0.5 m, and refined.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from orchard_cli.mapping import DistanceField
from orchard_cli.model.arrays import Points
from orchard_cli.model.mission import Limits
from orchard_cli.model.trajectory import DEGREE, Trajectory

from .checks import Inspection, inspect
from .optimise import REFINE, WARM_UP, Targets, Weights, optimise
from .pacing import pace
from .search import NoRoute, find_route
from .splice import Head, splice
from .stopwatch import Stopwatch
from .subdivision import controls_of, halved, knot_state
from .timing import CRUISE


@dataclass(frozen=True, slots=True)
class Manner:
    """How a detour is flown. Distances are what the field must show."""

    accept: float  # m, floor of the checked result
    aim: float  # m, d_thr of eq. 20
    ahead: float = 1.5  # m of reference after the rejoin point that are checked too
    furthest: float = 5.0  # m to the side of the reference, at most
    cruise: float = 1.0  # share of the reference's speed
    approach: float = 0.0  # m of the reference before the rejoin point that the guide runs along
    stray: float = 0.05  # per m: how much dearer a way is beside the path being flown
    pacing: float = 0.6  # share of the acceleration limit, between speeds
    effort: float = 0.95  # share of the acceleration limit that the optimisation aims at
    warm_up: Weights = field(default=WARM_UP)
    refine: Weights = field(default=REFINE)


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """Where a detour begins, what it goes round, and what it must respect."""

    begin: float  # s, when what is flown may change: the head may go on
    head: Head
    reference: Trajectory
    halvings: int  # of the optimisation's knot interval, to that of head and reference
    first: int  # the reference's knot that belongs to the head's last
    near: Points  # (n, 3) m, the path being flown
    field: DistanceField
    limits: Limits


@dataclass(frozen=True, slots=True, eq=False)
class Detour:
    """A checked trajectory back to the reference."""

    trajectory: Trajectory
    rejoin: float  # s, when it is the reference again
    guide_site: Points  # (n, 2) m
    found: Inspection


@dataclass(frozen=True, slots=True, eq=False)
class NoDetour:
    """Why a detour was turned down."""

    why: str


@dataclass(frozen=True, slots=True, eq=False)
class _Ends:
    """The three control points (3, 3) at either end of a detour, on the optimisation's knots."""

    interval: float  # s
    first: Points
    last: Points

    @property
    def speeds(self) -> tuple[float, float]:
        """m/s where the free points begin and end."""
        away, home = self.first[2] - self.first[1], self.last[1] - self.last[0]
        return (
            float(np.hypot(away[0], away[1])) / self.interval,
            float(np.hypot(home[0], home[1])) / self.interval,
        )


def find_detour(task: Task, rejoin: int, manner: Manner, watch: Stopwatch) -> Detour | NoDetour:
    """A detour from the head to knot `rejoin` of the reference, or why not."""
    ends = _ends(task, rejoin)
    replaced = _replaced(task, rejoin)
    approach = _approach(replaced, ends, manner.approach)
    with watch.stage("search"):
        route = find_route(
            task.field, ends.first[2, :2], approach[0], manner.accept, task.near, manner.stray
        )
    if isinstance(route, NoRoute):
        return NoDetour(route.why)
    guide = np.concatenate([route.points_site, approach[1:]])
    with watch.stage("optimise"):
        span = _optimised(task, ends, guide, replaced, manner)
    fine = halved(span, task.halvings)[DEGREE:-DEGREE]
    trajectory = splice(task.head, fine, task.reference, rejoin)
    with watch.stage("recheck"):
        begin = task.head.begin
        back = begin + (len(fine) + DEGREE) * trajectory.interval
        until = back + manner.ahead / max(ends.speeds[1], 0.1)
        found = inspect(trajectory, task.field, task.begin, until, manner.accept)
    why = _fault(found, task.limits) or _strays(span, replaced, manner.furthest)
    return NoDetour(why) if why else Detour(trajectory, back, guide, found)


def _ends(task: Task, rejoin: int) -> _Ends:
    fine = task.reference.interval
    coarse = fine * 2**task.halvings
    head = task.head.control_points_site
    return _Ends(
        coarse,
        controls_of(knot_state(head, len(head) - DEGREE, fine), coarse),
        controls_of(knot_state(task.reference.control_points_site, rejoin, fine), coarse),
    )


def _replaced(task: Task, rejoin: int) -> Points:
    """The reference (n, 3) between the first and the last free control point."""
    knots = 2**task.halvings
    control = task.reference.control_points_site
    first = min(task.first + knots, rejoin - knots - 1)
    return control[first + 1 : rejoin - knots + 2]


def _approach(replaced: Points, ends: _Ends, length: float) -> Points:
    """The last `length` metres (n, 2) of the way along the reference to the rejoin point."""
    goal = ends.last[:1, :2]
    if length <= 0:
        return goal
    points = replaced[:-1, :2]
    left = np.cumsum(np.hypot(*np.diff(points[::-1], axis=0).T))
    return np.concatenate([points[len(points) - 1 - int(np.searchsorted(left, length)) :], goal])


def _optimised(task: Task, ends: _Ends, guide: Points, replaced: Points, manner: Manner) -> Points:
    """The detour's control points (n, 3), its fixed ends included."""
    limits = task.limits
    paced = pace(
        guide, replaced, task.reference.interval, ends.interval, ends.speeds, manner.cruise,
        manner.pacing * limits.acceleration,
    )  # fmt: skip
    start = np.concatenate([ends.first[:2, :2], paced, ends.last[1:, :2]])
    fast = max(*ends.speeds, CRUISE * limits.speed)
    targets = Targets(
        ends.interval,
        min(fast, 0.99 * limits.speed),
        manner.effort * limits.acceleration,
        manner.aim,
    )
    warm = optimise(start, start, task.field, manner.warm_up, targets, iterations=30)
    fine = optimise(warm, start, task.field, manner.refine, targets)
    span = np.empty((len(fine), 3))
    span[:, :2] = fine
    own = np.linspace(0.0, 1.0, len(replaced))
    share = np.linspace(0.0, 1.0, len(fine) - 4)
    drop = ends.first[2, 2] - replaced[0, 2]
    span[2:-2, 2] = np.interp(share, own, replaced[:, 2]) + (1 - share) * drop
    span[:DEGREE, 2], span[-DEGREE:, 2] = ends.first[:, 2], ends.last[:, 2]
    return span


def _fault(found: Inspection, limits: Limits) -> str:
    """What is wrong with a trajectory; empty when nothing is."""
    if found.blocked_at is not None:
        return f"comes within {found.clearance:.2f} m of an obstacle"
    for what, is_, may, unit, tolerance in (
        ("speed", found.speed, limits.speed, "m/s", 1.03),
        ("acceleration", found.acceleration, limits.acceleration, "m/s²", 1.01),
        ("turning", found.turning, limits.yaw_rate, "rad/s", 1.03),
    ):
        if is_ > may * tolerance:
            return f"{what} {is_:.2f} over {may:.2f} {unit}"
    return ""


def _strays(span: Points, replaced: Points, furthest: float) -> str:
    """Whether a detour leaves the reference by too far; empty when not."""
    apart = np.hypot(*(span[:, None, :2] - replaced[None, ::4, :2]).T).min(axis=0).max()
    return f"leads {apart:.1f} m away from the route" if apart > furthest else ""
