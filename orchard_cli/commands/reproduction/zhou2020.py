"""Zhou 2020 (EGO-Planner): our `ego` beside its authors' program, measured in the same fields.

What stands as the paper's is what was measured of that program, with its published settings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import median
from time import thread_time
from typing import TYPE_CHECKING

import numpy as np

from orchard_cli.avoidance.ego import Ego, EgoSettings
from orchard_cli.avoidance.ego.obstacles import look
from orchard_cli.avoidance.ego.replan import Curve, Task, from_rest, task_pace
from orchard_cli.avoidance.ego.route import aim
from orchard_cli.commands.benchmarks.pole_fields import HEIGHT, Case, Field, cases
from orchard_cli.commands.benchmarks.replanning import clearance
from orchard_cli.model.arrays import Points
from orchard_cli.model.mission import Limits
from orchard_cli.model.trajectory import DEGREE, Trajectory

from . import ideal
from .desk import Desk
from .rows import Row

if TYPE_CHECKING:
    from orchard_cli.model.mission import Mission
    from orchard_cli.model.world import Pole

TITLE = "Zhou et al. 2020: EGO-Planner, beside its authors' program"
REPLANS = 1000  # of each kind
RUNS = 4  # flights of each mode, the poles shifted by JITTER more in each
JITTER = 0.005  # m
_FREE = 0.35  # m from the target to a pole's surface: its axis is 0.5 m away
_LEAVES = 0.05  # m: more is another height
_LIMITS = Limits(speed=1.0, acceleration=1.0, acceleration_along=1.0)
_PUBLISHED = EgoSettings.published()

_REPLANS = {  # first call ok, ok within 4, pairs used, least clearance, off height, crosses a pole
    (0.02, False, 0.099): (99.2, 99.9, 4.7, 0.13, None, 1.2),
    (0.05, False, 0.099): (99.2, 99.9, 13.1, 0.13, None, 3.2),
    (0.10, False, 0.099): (96.8, 99.8, 23.7, 0.10, None, 6.4),
    (0.00, True, 0.099): (92.6, 100.0, 92.5, None, 8.0, None),
    (0.02, True, 0.099): (91.5, 99.6, 92.2, None, 8.0, None),
    (0.05, True, 0.099): (89.8, 99.6, 91.4, None, 8.0, None),
    (0.05, False, 0.299): (94.7, 98.0, 21.5, None, None, None),
}
_REPLAN_COLUMNS = (
    ("first call succeeds", "%"), ("within four", "%"), ("pairs used", "%"),
    ("least clearance in the first two thirds", "m"), ("leaves the height by 5 cm", "%"),
    ("crosses a pole in the last third", "%"),
)  # fmt: skip
_COLUMNS = (
    ("flown", "m"), ("time", "s"), ("least clearance", "m"), ("deviation, mean", "m"),
    ("deviation, most", "m"), ("curves", ""),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Mode:
    """A way to fly the lemon orchard, and what the original made of it."""

    name: str
    settings: EgoSettings
    stops: bool
    original: tuple[float | None, ...]
    note: str


_MODES = (
    _Mode("one goal after the other", _PUBLISHED, True,
          (306.5, 395.7, 0.28, 0.034, 0.62, 195), "the original: ten flights"),
    _Mode("one goal after the other, inflation 0.299 m",
          replace(_PUBLISHED, inflation=0.299), True,
          (307.35, 397.1, 0.578, 0.041, 0.82, 195), "the original: one flight"),
    _Mode("all goals at once, looking 4 m ahead", replace(_PUBLISHED, horizon=4.0), False,
          (310.45, 385.3, 0.30, 0.064, 0.59, 202), "the original: six flights"),
    _Mode("all goals at once, looking 7.5 m ahead", _PUBLISHED, False,
          (265.82, 328.4, 0.243, 0.276, 3.0, 176), "the original: one flight"),
)  # fmt: skip


def replans(desk: Desk) -> list[Row]:
    """One replan in a known map, 7.5 m ahead."""
    rows = []
    for (density, forced, inflation), original in _REPLANS.items():
        name = f"{density:g} poles/m²{', one forced ahead' if forced else ''}"
        name += "" if inflation == _PUBLISHED.inflation else f", inflation {inflation:g} m"
        desk.say(f"replans: {name}")
        ours, took = _replanned(Field(name, density, forced, _FREE), inflation, desk.seed)
        note = f"{REPLANS} replans; median {took:.2f} ms here"
        for k, (column, unit) in enumerate(_REPLAN_COLUMNS):
            said = note if k == 0 else ""
            rows.append(Row("replans", name, column, original[k], ours[k], unit, said))
    return rows


def orchard(desk: Desk) -> list[Row]:
    """The lemon orchard with its four poles, 1 m/s and 1 m/s², with perfect tracking."""
    mission, poles = _lemon()
    rows = []
    for mode in _MODES:
        desk.say(f"orchard: {mode.name}")
        found = [_flight(mode, mission, _shifted(poles, k * JITTER)) for k in range(RUNS)]
        for k, (column, unit) in enumerate(_COLUMNS):
            values = [one[k] for one in found]
            rows.append(Row(
                "orchard", mode.name, column, mode.original[k], median(values), unit,
                mode.note if k == 0 else "", RUNS, min(values), max(values),
            ))  # fmt: skip
    return rows


TABLES = {"replans": replans, "orchard": orchard}


def _replanned(field: Field, inflation: float, seed: int) -> tuple[tuple[float | None, ...], float]:
    """The columns of one kind of field, and a first call's median time, ms."""
    settings = replace(_PUBLISHED, inflation=inflation)
    first, within, pairs, off, crosses, took = 0, 0, 0, 0, 0, []
    nearest = np.inf
    for number, case in enumerate(cases(field, REPLANS, seed)):
        task, random = _task(case, settings), np.random.default_rng((seed, number))
        began = thread_time()
        found = from_rest(task, settings)
        took.append(1e3 * (thread_time() - began))
        first += isinstance(found, Curve)
        for failures in range(3):
            if isinstance(found, Curve):
                break
            found = from_rest(task, settings, failures, random)
        if not isinstance(found, Curve):
            continue
        within, pairs = within + 1, pairs + (found.touched > 0)
        times = np.arange(found.begin, found.end, 0.02)
        path = found.trajectory.sample(times)[0]
        checked = int(settings.checked * len(path))
        nearest = min(nearest, clearance(path[:checked], case.poles))
        crosses += clearance(path[checked:], case.poles) < 0
        off += bool(np.abs(path[:, 2] - HEIGHT).max() > _LEAVES)
    least = float(nearest) if np.isfinite(nearest) else None
    share = 100 / REPLANS
    columns = (first * share, within * share, pairs * share, least, off * share, crosses * share)
    return columns, float(np.median(took))


def _task(case: Case, settings: EgoSettings) -> Task:
    told = case.situation
    route, now, commit = told.reference, told.now, told.commit
    here = route.at(commit).position_site
    target = aim(route, here, now, now, settings.horizon, route.end)
    corners = np.stack([here, target.state.position_site])
    inflation = settings.inflation or told.limits.airframe_radius
    obstacles = look(told.grid, corners, settings.around, settings.above, inflation)
    return Task(now, commit, route, route, target, obstacles, task_pace(_LIMITS, settings))


def _lemon() -> tuple[Mission, Sequence[Pole]]:
    from orchard_cli import mission as missions
    from orchard_cli.commands.shipped import shipped
    from orchard_cli.simulator.world_file import load_with_bytes

    mission = missions.load(shipped("lemon-gazebo.mission.json"))
    world, _ = load_with_bytes(shipped("lemon-gazebo.world.toml"), mission.orchard)
    return replace(mission, limits=_LIMITS), world.poles


def _shifted(poles: Sequence[Pole], by: float) -> list[Pole]:
    return [replace(pole, x=pole.x + by, y=pole.y + by) for pole in poles]


def _flight(mode: _Mode, mission: Mission, poles: Sequence[Pole]) -> tuple[float, ...]:
    from orchard_cli.motion.fit import distances, lengths_of

    waypoints = np.asarray(mission.waypoints_site)
    reference = _goals(mission) if mode.stops else _at_once(waypoints)
    flown = ideal.fly(Ego(mode.settings), reference, poles, _LIMITS)
    away = [np.linalg.norm(flown.places - end, axis=1) for end in waypoints[[0, -1]]]
    inside = slice(int(np.argmin(away[0])), int(np.argmin(away[1])) + 1)
    places, times = flown.places[inside], flown.times[inside]
    off = distances(places * [1, 1, 0], waypoints * [1, 1, 0])
    moved = float(lengths_of(places)[-1])
    return (
        moved, float(times[-1] - times[0]), flown.clearance(poles),
        float(off.mean()), float(off.max()), float(flown.curves),
    )  # fmt: skip


def _goals(mission: Mission) -> Trajectory:
    """Leg by leg, at rest in each waypoint."""
    from orchard_cli.mission import with_stops

    start, end = np.asarray(mission.waypoints_site)[[0, -1]]
    whole = with_stops(mission).trajectory
    points = whole.control_points_site
    first = int(np.argmin(np.linalg.norm(points - start, axis=1)))
    last = int(len(points) - 1 - np.argmin(np.linalg.norm(points[::-1] - end, axis=1)))
    return Trajectory(0.0, whole.interval, points[first : last + 1])


def _at_once(waypoints: Points) -> Trajectory:
    """Straight legs at constant speed, from rest."""
    from orchard_cli.motion.fit import lengths_of

    lengths = lengths_of(waypoints)
    interval = 0.5
    along = np.append(np.arange(0.0, lengths[-1], interval * _LIMITS.speed), lengths[-1])
    points = np.column_stack([np.interp(along, lengths, axis) for axis in waypoints.T])
    ends = (DEGREE - 1, DEGREE - 1)
    return Trajectory(0.0, interval, np.pad(points, (ends, (0, 0)), mode="edge"))
