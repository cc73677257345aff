"""The `guided` system: path-guided B-spline replanning after Liu et al. 2024, §4."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orchard_cli.mapping import Band, DistanceField, distance_field
from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.trajectory import DEGREE, Trajectory
from orchard_cli.motion.braking import brake_within
from orchard_cli.motion.checks import inspect
from orchard_cli.motion.detour import Detour, Manner, NoDetour, Task, find_detour
from orchard_cli.motion.situation import Avoid, Keep, Situation, Stop, Verdict
from orchard_cli.motion.splice import (
    Head,
    counterpart,
    head_at,
    knots_of,
    nearest_knot,
    shared_tail,
)
from orchard_cli.motion.stopwatch import Stopwatch

Flags = NDArray[np.bool_]
_SPARE = 0.03  # m: between two knots the reference may be nearer than at both
WIDEST = 0.0  # as a lead: rejoin in the middle of the longest free stretch
_APPROACH = 1.5  # m of reference that a slow detour runs along before it rejoins, to speed up
_LEAST_ROOM = 0.3  # m of free reference on both sides of such a rejoin point
_FROM_END = 1.0  # m that are enough behind an obstacle to come to rest at the reference's end


@dataclass(frozen=True, slots=True)
class Attempt:
    """One way to go about a detour."""

    lead: float  # m of free reference between the obstacle and the rejoin point, or WIDEST
    cruise: float = 1.0  # share of the reference's speed
    other_side: bool = False
    tight: bool = False  # without the room for tracking errors, which are small when slow


@dataclass(frozen=True, slots=True)
class GuidedSettings:
    """How `guided` looks and how far it keeps away.

    `close` < `accept` < `aim` are added to Limits.clearance + half a cell: a new trajectory has
    room for tracking errors, and noise of one cell does not make it a case for another one.
    """

    look_ahead: float = 7.0  # m of path that is checked: a little more than a D455 sees
    close: float = 0.05  # m: a trajectory that comes nearer is worth replacing
    accept: float = 0.10  # m: a new trajectory must keep this
    aim: float = 0.20  # m: what the optimisation aims at
    below: float = 0.35  # m under the flight height that must be free
    above: float = 0.35  # m over it
    half_size: float = 8.0  # m of the local map
    reach: float = 1.8  # m up to which distances are known
    window: float = 13.0  # m of reference in which a rejoin point is looked for
    ahead: float = 1.5  # m of free reference behind the rejoin point
    gentle: float = 0.6  # share of the acceleration limit for early braking
    stop_short: float = 0.2  # m before the first place that is too near
    attempts: tuple[Attempt, ...] = (
        Attempt(4.5),
        Attempt(4.5, cruise=0.8),
        Attempt(4.5, other_side=True),
        Attempt(3.0, cruise=0.6),
        Attempt(3.0, cruise=0.6, other_side=True),
        Attempt(WIDEST, cruise=0.6),
        Attempt(3.0, cruise=0.35),
        Attempt(WIDEST, cruise=0.35),
        Attempt(WIDEST, cruise=0.35, other_side=True),
        Attempt(WIDEST, cruise=0.35, tight=True),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """What one call looks at."""

    situation: Situation
    head: Head
    tail: int  # control points that the active trajectory shares with the reference's end
    first: int  # the reference's knot beside the head's last
    rejoins: Points  # (n, 3) m, the reference's knots from `first` on, within the window
    band: Band
    field: DistanceField
    floor: float  # m, least distance in the field: Limits.clearance and half a cell

    @property
    def stopped(self) -> bool:
        """Whether the active trajectory ends before the reference does."""
        return self.tail < DEGREE


class Guided:
    """Keeps the reference until it is blocked; then A*, two optimisations and a check.

    Remembers how far along the reference it is, for when it was stopped beside it.
    """

    name = "guided"

    def __init__(self, settings: GuidedSettings | None = None) -> None:
        self._settings = settings or GuidedSettings()
        self._progress = 0

    def plan(self, situation: Situation) -> Verdict:
        """Keep the active trajectory, go round what blocks it, or stop before it."""
        watch = Stopwatch()
        with watch.stage("distance_field"):
            view = self._look(situation)
        active, s = situation.active, self._settings
        with watch.stage("check"):
            until = situation.now + s.look_ahead / situation.limits.speed
            seen = inspect(active, view.field, situation.now, until, view.floor + s.close)
        if seen.blocked_at is None and not view.stopped:
            return Keep(stages_ms=watch.stages_ms)
        with watch.stage("replan"):
            found = self._round(view, seen.blocked_time, seen.blocked_at or 0.0, watch)
            verdict = found if isinstance(found, Avoid) else self._stop(view, found.why)
        return replace(verdict, stages_ms=watch.stages_ms)

    def _look(self, situation: Situation) -> _View:
        s, reference = self._settings, situation.reference
        head = head_at(situation.active, situation.commit)
        tail = shared_tail(situation.active, reference)
        here = knots_of(head.control_points_site[-DEGREE:])[0]
        if tail < DEGREE:
            first = nearest_knot(reference, here, self._progress, self._progress + 40)
        else:
            knot = len(head.control_points_site) - DEGREE
            first = counterpart(situation.active, reference, tail, knot, here)
            self._progress = first
        rejoins = knots_of(reference.control_points_site[first : first + 100])
        rejoins = rejoins[: int(np.searchsorted(_lengths(rejoins), s.window)) + 1]
        corners = np.vstack([here, rejoins])
        low, high = corners.min(axis=0), corners.max(axis=0)
        band = situation.grid.band(
            (low + high)[:2] / 2, s.half_size, float(low[2]) - s.below, float(high[2]) + s.above
        )
        floor = situation.limits.clearance + band.cell / 2
        field = distance_field(band, s.reach)
        return _View(situation, head, tail, first, rejoins, band, field, floor)

    def _round(
        self, view: _View, blocked_time: float, blocked_at: float, watch: Stopwatch
    ) -> Avoid | NoDetour:
        """Try the attempts in turn; the first trajectory that passes its check is taken."""
        s = self._settings
        task = self._task(view, blocked_time)
        manner = Manner(view.floor + s.accept, view.floor + s.aim, s.ahead)
        result = NoDetour("")
        guide: Points | None = None
        for attempt in s.attempts:
            rejoin, room = self._rejoin(view, task, attempt.lead)
            if rejoin is None:
                result = NoDetour("the way ahead is not free again within the local map")
                continue
            if attempt.other_side and guide is None:
                continue
            tried = replace(
                manner,
                cruise=attempt.cruise,
                accept=view.floor if attempt.tight else manner.accept,
                approach=min(_APPROACH, room) if attempt.cruise < 0.7 else 0.0,
            )
            found = find_detour(task, rejoin, tried, watch, guide if attempt.other_side else None)
            if isinstance(found, Detour):
                height = np.full(len(found.guide_site), view.rejoins[0, 2])
                return Avoid(
                    found.trajectory, view.head.begin, found.rejoin,
                    "resuming" if view.stopped else f"blocked in {blocked_at:.1f} m",
                    blocked_at, np.column_stack([found.guide_site, height]),
                )  # fmt: skip
            result = found
            if guide is None and len(found.guide_site):
                guide = found.guide_site
        return result

    def _task(self, view: _View, blocked_time: float) -> Task:
        situation = view.situation
        at = situation.active.at(min(blocked_time, situation.active.end)).position_site
        if view.stopped:
            blocked = np.flatnonzero(~self._free(view))
            at = view.rejoins[blocked[0] if len(blocked) else 0]
        points = situation.active.control_points_site
        flown = points[len(view.head.control_points_site) - 1 :][:40]
        near = view.rejoins if view.stopped or len(flown) == 0 else flown
        return Task(
            view.head, situation.reference, view.first, near, at[:2], view.field, situation.limits
        )  # fmt: skip

    def _free(self, view: _View) -> Flags:
        """Which of the rejoin points are free, with a little to spare between them."""
        return view.field.at(view.rejoins[:, :2]) >= view.floor + self._settings.accept + _SPARE

    def _rejoin(self, view: _View, task: Task, lead: float) -> tuple[int | None, float]:
        """The first knot of the reference that is `lead` m behind the obstacle, and free ahead.

        With it, the free length before it, m.
        """
        s = _lengths(view.rejoins)
        beside = int(np.argmin(np.linalg.norm(view.rejoins[:, :2] - task.conflict, axis=1)))
        free = self._free(view)
        behind = s - np.maximum.accumulate(np.where(free, s[beside], s))
        ahead = np.minimum.accumulate(np.where(free, np.inf, s)[::-1])[::-1] - s
        if lead == WIDEST:
            room = np.minimum(behind, ahead)
            good = (room == room.max()) & (room > _LEAST_ROOM)
        else:
            good = (behind >= lead) & (ahead >= self._settings.ahead)
            last = len(s) - 1
            if view.first + last == len(task.reference.control_points_site) - DEGREE:
                good[last] |= behind[last] >= min(lead, _FROM_END)
        found = np.flatnonzero(good)
        return (view.first + int(found[0]), float(behind[found[0]])) if len(found) else (None, 0.0)

    def _stop(self, view: _View, why: str) -> Keep | Stop:
        """Brake before what blocks the way, as late as that is gentle, within what was seen."""
        situation, s = view.situation, self._settings
        active, limits = situation.active, situation.limits
        until = situation.now + s.look_ahead / limits.speed
        seen = inspect(active, view.field, situation.now, until, view.floor)
        if seen.blocked_at is None:
            return Keep(f"stopped: {why}" if view.stopped else f"close, but {why}")
        left = inspect(active, view.field, situation.commit, until, view.floor)
        room = 0.0 if left.blocked_at is None else left.blocked_at - s.stop_short
        room = min(room, _observed(active, view.band, situation.commit, until))
        most = limits.acceleration
        brake = brake_within(active, situation.commit, max(room, 0.0), s.gentle * most, most)
        if not brake.fits:
            why = f"{why}; full braking does not end before it"
        return Stop(brake.trajectory, why, seen.blocked_at)


def _observed(active: Trajectory, band: Band, begin: float, end: float) -> float:
    """Path length from `begin` to the first place that was never seen, m; inf when all was."""
    times = np.arange(begin, min(end, active.end), active.interval / 8)
    if len(times) == 0:
        return np.inf
    places = active.sample(times)[0]
    cells = np.floor((places[:, :2] - band.origin_site) / band.cell).astype(np.int64)
    cells = np.clip(cells, 0, np.array(band.observed.shape) - 1)
    unseen = np.flatnonzero(~band.observed[cells[:, 0], cells[:, 1]])
    return float(_lengths(places)[unseen[0]]) if len(unseen) else np.inf


def _lengths(points: Points) -> Array:
    """Horizontal path length from the first of the points to each (n,), m."""
    steps = np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])
