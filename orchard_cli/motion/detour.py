"""One detour: a guide path, sampled, optimised twice, and checked (Liu 2024, §4.2 to §4.4)."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from orchard_cli.mapping import DistanceField
from orchard_cli.model.arrays import Points, Vector
from orchard_cli.model.mission import Limits
from orchard_cli.model.trajectory import DEGREE, Trajectory

from .checks import Inspection, inspect
from .optimise import REFINE, WARM_UP, Targets, Weights, optimise
from .pacing import pace
from .search import NoRoute, Wall, find_route
from .splice import Head, splice
from .stopwatch import Stopwatch

_WALL = 4.0  # m, how far a wall across one side reaches


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
    warm_up: Weights = field(default=WARM_UP)
    refine: Weights = field(default=REFINE)


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """Where a detour begins, what it goes round, and what it must respect."""

    head: Head
    reference: Trajectory
    first: int  # the reference's knot that belongs to the head's last
    near: Points  # (n, 3) m, the path being flown
    conflict: Vector  # (2,) m, where that path is blocked
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
    """Why a detour was turned down, and the guide path that was tried."""

    why: str
    guide_site: Points = field(default_factory=lambda: np.empty((0, 2)))


def find_detour(
    task: Task, rejoin: int, manner: Manner, watch: Stopwatch, avoid_side: Points | None = None
) -> Detour | NoDetour:
    """A detour from the head to knot `rejoin` of the reference, or why not.

    `avoid_side`: a guide path (n, 2) on the side that is not to be taken this time.
    """
    head, tail = task.head.control_points_site, task.reference.control_points_site[rejoin:]
    approach = _approach(task, rejoin, manner.approach)
    wall = None if avoid_side is None else _wall(task.conflict, avoid_side)
    with watch.stage("search"):
        route = find_route(
            task.field, head[-1, :2], approach[0], manner.accept, task.near, manner.stray, wall
        )
    if isinstance(route, NoRoute):
        return NoDetour(route.why)
    guide = np.concatenate([route.points_site, approach[1:]])
    with watch.stage("optimise"):
        free = _optimised(task, guide, rejoin, manner)
    trajectory = splice(task.head, free, task.reference, rejoin)
    with watch.stage("recheck"):
        knots = len(head) + len(free)
        back = trajectory.start + knots * trajectory.interval
        cruise = max(float(np.linalg.norm(tail[1] - tail[0])) / trajectory.interval, 0.1)
        until = back + manner.ahead / cruise
        found = inspect(trajectory, task.field, task.head.begin, until, manner.accept)
    why = _fault(found, task.limits) or _strays(task, free, rejoin, manner.furthest)
    if why:
        return NoDetour(why, guide)
    return Detour(trajectory, back, guide, found)


def _approach(task: Task, rejoin: int, length: float) -> Points:
    """The reference's control points (n, 2) over the last `length` metres up to `rejoin`."""
    points = task.reference.control_points_site[task.first : rejoin + 1, :2]
    left = np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)[::-1])
    return points[len(points) - 1 - int(np.searchsorted(left, length)) :]


def _optimised(task: Task, guide: Points, rejoin: int, manner: Manner) -> Points:
    """The free control points (f, 3) between the head and the reference."""
    head, tail = task.head.control_points_site, task.reference.control_points_site[rejoin:]
    interval, limits = task.head.interval, task.limits
    replaced = task.reference.control_points_site[
        min(task.first + DEGREE - 1, rejoin - 1) : rejoin + 1
    ]
    speeds = (
        float(np.linalg.norm(head[-1, :2] - head[-2, :2])) / interval,
        float(np.linalg.norm(tail[1, :2] - tail[0, :2])) / interval,
    )
    paced = pace(
        guide, replaced, interval, speeds, manner.cruise, manner.pacing * limits.acceleration
    )
    start = np.concatenate([head[-DEGREE:-1, :2], paced, tail[1:DEGREE, :2]])
    targets = Targets(interval, 0.99 * limits.speed, 0.95 * limits.acceleration, manner.aim)
    warm = optimise(start, start, task.field, manner.warm_up, targets, iterations=30)
    fine = optimise(warm, start, task.field, manner.refine, targets)[DEGREE:-DEGREE]
    share = np.linspace(0.0, 1.0, len(fine) + 2)[1:-1]
    heights = np.interp(share, np.linspace(0.0, 1.0, len(replaced)), replaced[:, 2])
    heights += (1 - share) * (head[-1, 2] - replaced[0, 2])
    return np.column_stack([fine, heights])


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


def _strays(task: Task, free: Points, rejoin: int, furthest: float) -> str:
    """Whether a detour leaves the reference by too far; empty when not."""
    replaced = task.reference.control_points_site[task.first : rejoin + 1, :2]
    apart = np.linalg.norm(free[:, None, :2] - replaced[None], axis=2).min(axis=1).max()
    return f"leads {apart:.1f} m away from the route" if apart > furthest else ""


def _wall(conflict: Vector, guide: Points) -> Wall | None:
    """From the obstacle across the side that a guide path takes."""
    dense = np.concatenate([np.linspace(a, b, 9) for a, b in pairwise(guide)])
    offsets = dense - conflict
    distances = np.linalg.norm(offsets, axis=1)
    nearest = int(np.argmin(distances))
    if distances[nearest] < 0.05:
        return None
    return Wall(conflict, conflict + _WALL * offsets[nearest] / distances[nearest])
