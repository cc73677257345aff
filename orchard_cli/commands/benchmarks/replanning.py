"""One replan in a known map, again and again: how long, how often found, and how near to poles."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import thread_time
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from orchard_cli.flight.ports import Avoidance
from orchard_cli.model.arrays import Points
from orchard_cli.model.trajectory import DEGREE, Trajectory
from orchard_cli.motion import stopwatch
from orchard_cli.motion.situation import Avoid, Keep, Verdict

from .pole_fields import HEIGHT, RADIUS, Case, Field, cases
from .samples import Samples, Spread

WARM_UP = 20  # calls that are not counted
_CLOCK = "perf_counter"  # what motion/stopwatch.py reads
BIN = 0.5  # m
TICK = 0.02  # s between two places that are checked
MAPPING = ("distance_field", "window")
"""Stages of `plan` that prepare the map for planning; EGO-Planner does that in its map's update."""


@dataclass(slots=True)
class Tally:
    """What the calls in one kind of field came to."""

    plan_ms: list[float] = field(default_factory=list)  # every call, whole, CPU
    replan_ms: list[float] = field(default_factory=list)  # of replans, without preparing the map
    clearances: list[float] = field(default_factory=list)  # m, of the trajectories returned
    stops: list[float] = field(default_factory=list)  # m, of those that brake to rest
    height_error: float = 0.0  # m, greatest
    found_at: list[tuple[float, bool]] = field(default_factory=list)  # m to a forced pole; found?


def measure(
    make: Callable[[], Avoidance], kinds: Sequence[Field], count: int, seed: int, samples: Samples
) -> dict[str, Tally]:
    """`count` first calls of a fresh system in each kind of field.

    Times the system's own stages into `samples` under their names.
    """
    with cpu_stopwatch():
        for case in cases(kinds[-1], WARM_UP, seed + 1):
            make().plan(case.situation)
        return {kind.name: _tally(make, kind, count, seed, samples) for kind in kinds}


def _tally(
    make: Callable[[], Avoidance], kind: Field, count: int, seed: int, samples: Samples
) -> Tally:
    tally = Tally()
    for case in cases(kind, count, seed):
        system = make()
        began = thread_time()
        verdict = system.plan(case.situation)
        took = (thread_time() - began) * 1e3
        tally.plan_ms.append(took)
        samples.add_cpu(verdict.stages_ms)
        if "replan" in verdict.stages_ms:
            prepared = sum(verdict.stages_ms.get(stage, 0.0) for stage in MAPPING)
            tally.replan_ms.append(took - prepared)
            _look_at(case, verdict, tally)
    return tally


def _look_at(case: Case, verdict: Verdict, tally: Tally) -> None:
    """Judge a replan by what came out of it."""
    if case.forced_at is not None:
        tally.found_at.append((case.forced_at, isinstance(verdict, Avoid)))
    if isinstance(verdict, Keep):
        return
    found = isinstance(verdict, Avoid)
    until = verdict.rejoin if isinstance(verdict, Avoid) else verdict.trajectory.end
    path = _path(verdict.trajectory, case.situation.now, until)
    (tally.clearances if found else tally.stops).append(clearance(path, case.poles))
    tally.height_error = max(tally.height_error, float(np.abs(path[:, 2] - HEIGHT).max()))


def _path(trajectory: Trajectory, begin: float, until: float) -> Points:
    """Where a trajectory leads from `begin` to `until` or its end: (n, 3) m.

    By scipy's B-spline: the check shares no code with what it checks.
    """
    control = trajectory.control_points_site
    knots = trajectory.start + (np.arange(len(control) + DEGREE + 1) - DEGREE) * trajectory.interval
    last = min(float(knots[-DEGREE - 1]), until)
    times = np.append(np.arange(begin, last, TICK), last)
    return np.asarray(BSpline(knots, control, DEGREE)(times))


def clearance(path: Points, poles: Points) -> float:
    """Least distance of a path (n, 3) to the surfaces of poles (m, 2), m; inf without poles."""
    if len(poles) == 0:
        return float("inf")
    offsets = path[:, None, :2] - poles[None]
    return float(np.hypot(offsets[..., 0], offsets[..., 1]).min()) - RADIUS


def summary(tally: Tally, margin: float, radius: float) -> dict[str, Any]:
    """The figures of one kind of field for the JSON document; what does not exist is null.

    `margin` and `radius` m: the least clearance asked for, and the airframe's own radius.
    """
    flown = np.array(tally.clearances)
    replans = len(tally.replan_ms)
    return {
        "n": len(tally.plan_ms),
        "replanned_share": replans / len(tally.plan_ms),
        "first_call_share": len(flown) / replans if replans else None,
        "first_call_by_distance_m": _by_distance(tally.found_at),
        "replan": Spread.of(tally.replan_ms) if replans else None,
        "plan": Spread.of(tally.plan_ms),
        "clearance_min_m": _least(tally.clearances),
        "margin_kept_share": float((flown >= margin).mean()) if len(flown) else None,
        "contacts": int((flown < radius).sum()),
        "stop_clearance_min_m": _least(tally.stops),
        "height_error_max_m": tally.height_error,
    }


def _by_distance(found_at: Sequence[tuple[float, bool]]) -> dict[str, float]:
    """Share found by the distance to the forced pole, in bins of BIN named by their lower end."""
    bins: dict[str, list[bool]] = {}
    for distance, found in sorted(found_at):
        bins.setdefault(f"{distance // BIN * BIN:.1f}", []).append(found)
    return {name: sum(found) / len(found) for name, found in bins.items()}


def _least(clearances: Sequence[float]) -> float | None:
    known = [value for value in clearances if np.isfinite(value)]
    return min(known) if known else None


@contextmanager
def cpu_stopwatch() -> Iterator[None]:
    """Let the systems' own stopwatches read this thread's CPU time instead of the wall's."""
    kept = getattr(stopwatch, _CLOCK)
    setattr(stopwatch, _CLOCK, thread_time)
    try:
        yield
    finally:
        setattr(stopwatch, _CLOCK, kept)
