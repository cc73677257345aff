"""The `guided` system: path-guided B-spline replanning after Liu et al. 2024, §4."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orchard_cli.mapping import Band, DistanceField, distance_field
from orchard_cli.model.arrays import Points
from orchard_cli.model.trajectory import DEGREE, Trajectory
from orchard_cli.motion.braking import brake, brake_within
from orchard_cli.motion.checks import Inspection, inspect
from orchard_cli.motion.detour import Detour, Manner, NoDetour, Task, find_detour
from orchard_cli.motion.rejoin import WIDEST, choose_rejoin, path_lengths
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
_GAP = 0.5  # m not looked at between what was, that do not count
_SLOW = 0.7  # share of cruise under which a detour runs along the route to speed up again


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
    close: float = 0.10  # m: a trajectory that comes nearer is worth replacing
    accept: float = 0.20  # m: a new trajectory must keep this
    aim: float = 0.30  # m: what the optimisation aims at
    below: float = 0.35  # m under the flight height that must be free
    above: float = 0.35  # m over it
    half_size: float = 8.0  # m of the local map
    reach: float = 1.8  # m up to which distances are known
    window: float = 13.0  # m of reference in which a rejoin point is looked for
    ahead: float = 1.5  # m of free reference behind the rejoin point
    furthest: float = 5.0  # m beside the route: a longer way round is the pilot's to choose
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

    Remembers how far along the reference it is, for when it was stopped beside it, and what it
    has tried.
    """

    name = "guided"
    needs: frozenset[str] = frozenset()

    def __init__(self, settings: GuidedSettings | None = None) -> None:
        self._settings = settings or GuidedSettings()
        self._progress = 0
        self._turn = 0  # the attempt whose turn it is when there is time
        self._guide: Points | None = None  # a way round that was turned down

    def plan(self, situation: Situation) -> Verdict:
        """Keep the active trajectory, go round what blocks it, or stop before it."""
        watch, s, active = Stopwatch(), self._settings, situation.active
        with watch.stage("distance_field"):
            view = self._look(situation)
        until = situation.now + s.look_ahead / situation.limits.speed
        with watch.stage("check"):
            close = inspect(active, view.field, situation.now, until, view.floor + s.close)
            soon = active.at(min(situation.commit + active.interval, active.end)).velocity_site
            if not _looks_ahead(view, active, situation.commit, float(np.linalg.norm(soon))):
                halt = brake(active, situation.commit, situation.limits.acceleration)
                return Stop(
                    halt, "the camera has not looked where this leads", 0.0, watch.stages_ms
                )
            if close.blocked_at is None and not view.stopped:
                self._turn, self._guide = 0, None
                return Keep(stages_ms=watch.stages_ms)
            blocked = inspect(active, view.field, situation.now, until, view.floor)
        with watch.stage("replan"):
            found = self._round(view, close, blocked.blocked_at is not None, watch)
            if isinstance(found, Avoid):
                verdict: Verdict = found
            elif blocked.blocked_at is not None:
                verdict = self._stop(view, blocked.blocked_at, until, found.why)
            else:
                verdict = Keep(f"{'stopped' if view.stopped else 'close'}: {found.why}")
        return replace(verdict, stages_ms=watch.stages_ms)

    def _look(self, situation: Situation) -> _View:
        s, reference = self._settings, situation.reference
        head = head_at(situation.active, situation.commit, reference.interval)
        tail = shared_tail(situation.active, reference)
        here = knots_of(head.control_points_site[-DEGREE:])[0]
        if tail < DEGREE:
            first = nearest_knot(reference, here, self._progress, self._progress + 40)
        else:
            knot = len(head.control_points_site) - DEGREE
            first = counterpart(situation.active, reference, tail, knot, here)
            self._progress = first
        rejoins = knots_of(reference.control_points_site[first : first + 100])
        rejoins = rejoins[: int(np.searchsorted(path_lengths(rejoins), s.window)) + 1]
        corners = np.vstack([here, rejoins])
        low, high = corners.min(axis=0), corners.max(axis=0)
        band = situation.grid.band(
            (low + high)[:2] / 2, s.half_size, float(low[2]) - s.below, float(high[2]) + s.above
        )
        floor = situation.limits.clearance + band.cell / 2
        field = distance_field(band, s.reach)
        return _View(situation, head, tail, first, rejoins, band, field, floor)

    def _round(
        self, view: _View, close: Inspection, urgent: bool, watch: Stopwatch
    ) -> Avoid | NoDetour:
        """Try the attempts; the first trajectory that passes its check is taken.

        All at once when the way is blocked; one in each call while the vehicle stands or passes
        only a little too close, when there is time.
        """
        s, limits = self._settings, view.situation.limits
        if abs(view.head.interval - view.situation.reference.interval) > 1e-9:
            return NoDetour("what is flown now is no part of the route")
        turn = self._turn % len(s.attempts)
        self._turn = 0 if urgent else turn + 1
        free = view.field.at(view.rejoins[:, :2]) >= view.floor + s.accept + _SPARE
        task = self._task(view, close, free)
        manner = Manner(view.floor + s.accept, view.floor + s.aim, s.ahead, s.furthest)
        last = view.first + len(view.rejoins) == len(task.reference.control_points_site) - 2
        result = NoDetour("no other way was tried yet")
        for attempt in s.attempts if urgent else s.attempts[turn : turn + 1]:
            place = choose_rejoin(view.rejoins, free, task.conflict, attempt.lead, s.ahead, last)
            if place is None:
                result = NoDetour("the route is not free again within the local map")
                continue
            if attempt.other_side and self._guide is None:
                continue
            slow = attempt.cruise < _SLOW
            tried = replace(
                manner,
                cruise=attempt.cruise,
                accept=view.floor if attempt.tight else manner.accept,
                approach=min(place.room, limits.speed**2 / limits.acceleration) if slow else 0.0,
            )
            found = find_detour(
                task, view.first + place.knot, tried, watch,
                self._guide if attempt.other_side else None,
            )  # fmt: skip
            if isinstance(found, Detour):
                cruise = limits.speed * attempt.cruise
                if not view.stopped or _looks_ahead(
                    view, found.trajectory, view.head.begin, cruise
                ):
                    return _avoid(view, found, close.blocked_at)
                found = NoDetour("the camera has not looked where it leads")
            result = found
            if not attempt.other_side and len(found.guide_site):
                self._guide = found.guide_site
        return result

    def _task(self, view: _View, close: Inspection, free: Flags) -> Task:
        """Where the way is blocked: on the active trajectory, or on the route while stopped."""
        active = view.situation.active
        conflict = active.at(min(close.blocked_time, active.end)).position_site
        flown = active.control_points_site[len(view.head.control_points_site) - 1 :][:40]
        if view.stopped:
            conflict, flown = view.rejoins[int(np.argmin(free))], view.rejoins
        return Task(
            view.head, view.situation.reference, view.first, flown, conflict[:2], view.field,
            view.situation.limits,
        )  # fmt: skip

    def _stop(self, view: _View, blocked_at: float, until: float, why: str) -> Stop:
        """Brake before what blocks the way, as late as that is gentle, within what was seen."""
        situation, s = view.situation, self._settings
        active, most = situation.active, situation.limits.acceleration
        left = inspect(active, view.field, situation.commit, until, view.floor)
        room = min(
            0.0 if left.blocked_at is None else left.blocked_at - s.stop_short,
            _looked(view, active, situation.commit, until),
        )
        halt = brake_within(active, situation.commit, max(room, 0.0), s.gentle * most, most)
        if not halt.fits:
            why = f"{why}; full braking does not end {s.stop_short} m before it"
        return Stop(halt.trajectory, why, blocked_at)


def _avoid(view: _View, detour: Detour, blocked_at: float | None) -> Avoid:
    height = np.full(len(detour.guide_site), view.rejoins[0, 2])
    return Avoid(
        detour.trajectory,
        begin=view.head.begin,
        rejoin=detour.rejoin,
        why="resuming" if view.stopped else f"blocked in {blocked_at:.1f} m",
        blocked_at=blocked_at or 0.0,
        guide_site=np.column_stack([detour.guide_site, height]),
    )


def _looks_ahead(view: _View, trajectory: Trajectory, begin: float, speed: float) -> bool:
    """Whether the camera has looked at all that full braking from `speed` would cross.

    Braking bites one interval after its knot; each frame asks again, up to the last before it.
    """
    limit = view.situation.limits.acceleration
    needed = speed**2 / (2 * limit) + speed * trajectory.interval
    return _looked(view, trajectory, begin, begin + 2 * needed / max(speed, 0.1)) >= needed


def _looked(view: _View, trajectory: Trajectory, begin: float, end: float) -> float:
    """Path length from `begin` to the first stretch not looked at yet, m; inf when all was.

    Looked at is what the map has observed, and what lies in the camera's view now: rays that end
    in the sky return nothing, and so clear nothing in the map. Gaps under _GAP do not count.
    """
    times = np.arange(begin, min(end, trajectory.end), trajectory.interval / 8)
    if len(times) == 0:
        return np.inf
    places, band = trajectory.sample(times)[0][:, :2], view.band
    cells = np.floor((places - band.origin_site) / band.cell).astype(np.int64)
    cells = np.clip(cells, 0, np.array(band.observed.shape) - 1)
    vehicle, camera = view.situation.vehicle, view.situation.frame.camera
    nose = np.array([np.cos(vehicle.yaw_site), np.sin(vehicle.yaw_site)])
    away = places - vehicle.position_site[:2]
    depth, side = away @ nose, np.abs(away @ np.array([-nose[1], nose[0]]))
    in_view = (depth < camera.range_max) & (side <= depth * camera.width / (2 * camera.fx))
    looked = band.observed[cells[:, 0], cells[:, 1]] | in_view
    lengths = path_lengths(places)
    last = np.maximum.accumulate(np.where(looked, lengths, 0.0))
    lost = np.flatnonzero(lengths - last >= _GAP)
    return float(last[lost[0]]) if len(lost) else np.inf
