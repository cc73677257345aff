"""Keep, go round, or stop: the decision of each frame."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from orchard_cli.motion.braking import brake, brake_within, slowed_to
from orchard_cli.motion.checks import Inspection, inspect
from orchard_cli.motion.detour import Detour, Manner, NoDetour, Task, find_detour
from orchard_cli.motion.optimise import HUG, HUGGED, REFINE, WARM_UP
from orchard_cli.motion.rejoin import Rejoin, Stretch, choose_rejoin
from orchard_cli.motion.situation import Avoid, Keep, Situation, Stop, Verdict
from orchard_cli.motion.splice import Head, knots_of
from orchard_cli.motion.stopwatch import Stopwatch

from .settings import Attempt, GuidedSettings
from .view import Eyes, View

_SPARE = 0.03  # m: between two knots the reference may be nearer than at both
_SLOW = 0.7  # share of cruise under which a detour runs along the route to speed up again
_NEAR = 400  # fine knots of what is flown that a way round is tied to


class Guided:
    """Keeps the reference until it is blocked; then A*, two optimisations and a check.

    Remembers how far along the reference it is, for when it was stopped beside it, and what it
    has tried.
    """

    name = "guided"
    needs: frozenset[str] = frozenset()

    def __init__(self, settings: GuidedSettings | None = None) -> None:
        self._settings = settings or GuidedSettings()
        self._eyes = Eyes(self._settings)
        self._turn = 0  # the attempt whose turn it is when there is time

    def plan(self, situation: Situation) -> Verdict:
        """Keep the active trajectory, go round what blocks it, or stop before it."""
        watch, s = Stopwatch(), self._settings
        with watch.stage("distance_field"):
            glance = self._eyes.glance(situation)
        active, until = glance.course.active, situation.now + s.look_ahead / situation.limits.speed
        with watch.stage("check"):
            close = inspect(active, glance.field, situation.now, until, glance.floor + s.close)
            soon = active.at(min(situation.commit + active.interval, active.end)).velocity_site
            if not glance.sight.looks_ahead(active, situation.commit, math.hypot(*soon)):
                halt = brake(active, situation.commit, situation.limits.acceleration)
                return Stop(
                    halt, "the camera has not looked where this leads", 0.0, watch.stages_ms
                )
            if close.blocked_at is None and not glance.course.stopped:
                self._turn = 0
                return Keep(stages_ms=watch.stages_ms)
        with watch.stage("distance_field"):
            view = self._eyes.look(glance)
        with watch.stage("check"):
            close = inspect(active, view.field, situation.now, until, view.floor + s.close)
            if close.blocked_at is None and not view.stopped:  # over or under where it must be free
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

    def _round(
        self, view: View, close: Inspection, urgent: bool, watch: Stopwatch
    ) -> Avoid | NoDetour:
        """Try the attempts; the first trajectory that passes its check is taken.

        All at once when the way is blocked; one in each call while the vehicle stands or passes
        only a little too close, when there is time.
        """
        s = self._settings
        if abs(view.head.interval - view.reference.interval) > 1e-9:
            return NoDetour("what is flown now is no part of the route")
        turn = self._turn % len(s.attempts)
        self._turn = 0 if urgent else turn + 1
        stretch = self._stretch(view, close)
        result = NoDetour("no other way was tried yet")
        speed = math.hypot(*view.active.at(view.head.begin).velocity_site)
        room = math.inf if close.blocked_at is None else close.blocked_at / max(speed, 0.1)
        for attempt in s.attempts if urgent else s.attempts[turn : turn + 1]:
            if urgent and room < attempt.room:
                continue
            place = choose_rejoin(stretch, attempt.lead, s.ahead)
            if place is None:
                result = NoDetour("the route is not free again within the local map")
                continue
            found = self._try(view, attempt, place, watch)
            if isinstance(found, Detour):
                cruise = view.situation.limits.speed * attempt.cruise
                if not view.stopped or view.sight.looks_ahead(
                    found.trajectory, view.head.begin, cruise
                ):
                    return _avoid(view, found, close.blocked_at, place)
                found = NoDetour("the camera has not looked where it leads")
            result = found
        return result

    def _stretch(self, view: View, close: Inspection) -> Stretch:
        """The route ahead, from where the active trajectory, or, while stopped, it is blocked."""
        floor = view.floor + self._settings.accept + _SPARE
        active = view.active
        conflict = active.at(min(close.blocked_time, active.end)).position_site
        if view.stopped:
            free = view.field.at(view.rejoins[:, :2]) >= floor
            conflict = view.rejoins[int(np.argmin(free))]
        return Stretch.of(view.rejoins, conflict[:2], view.field, floor, view.ends)

    def _try(
        self, view: View, attempt: Attempt, place: Rejoin, watch: Stopwatch
    ) -> Detour | NoDetour:
        s, limits, head = self._settings, view.situation.limits, view.head
        if math.isfinite(attempt.brake_to):
            slower = self._slowed(view, attempt.brake_to)
            if slower is None:
                return NoDetour("it is as slow already")
            head = slower
            rest = knots_of(head.control_points_site[-3:])[:, :2]
            if float(view.field.at(rest)[0]) < view.floor + (
                s.tight if attempt.tight else s.accept
            ):
                return NoDetour("it cannot slow down before the obstacle")
        near = view.rejoins if view.stopped else view.active.control_points_site[
            len(view.head.control_points_site) - 1 :
        ][:_NEAR]  # fmt: skip
        slow = attempt.cruise < _SLOW
        manner = Manner(
            accept=view.floor + (s.tight if attempt.tight else s.accept),
            aim=view.floor + (s.aim_tight if attempt.tight else s.aim),
            ahead=s.ahead,
            furthest=s.furthest,
            cruise=attempt.cruise,
            warm_up=HUG if slow and attempt.tight else WARM_UP,
            refine=HUGGED if slow and attempt.tight else REFINE,
            approach=min(place.room, limits.speed**2 / limits.acceleration) if slow else 0.0,
        )
        task = Task(
            view.head.begin, head, view.reference, s.halvings, view.first, near[::8], view.field,
            limits,
        )  # fmt: skip
        return find_detour(task, view.first + place.knot, manner, watch)

    def _slowed(self, view: View, speed: float) -> Head | None:
        head, limit = view.head, view.situation.limits.acceleration
        knot = len(head.control_points_site) - 3
        points = slowed_to(view.active, knot, speed, self._settings.hard * limit)
        if points is None or len(points) == len(head.control_points_site):
            return None
        return Head(head.start, head.interval, points)

    def _stop(self, view: View, blocked_at: float, until: float, why: str) -> Stop:
        """Brake before what blocks the way, as late as that is gentle, within what was seen."""
        situation, s, active = view.situation, self._settings, view.active
        most = situation.limits.acceleration
        left = inspect(active, view.field, situation.commit, until, view.floor)
        room = min(
            0.0 if left.blocked_at is None else left.blocked_at - s.stop_short,
            view.sight.looked(active, situation.commit, until),
        )
        halt = brake_within(active, situation.commit, max(room, 0.0), s.gentle * most, most)
        if not halt.fits:
            why = f"{why}; full braking does not end {s.stop_short} m before it"
        return Stop(halt.trajectory, why, blocked_at)


def _avoid(view: View, detour: Detour, blocked_at: float | None, place: Rejoin) -> Avoid:
    height = np.full(len(detour.guide_site), view.rejoins[0, 2])
    why = "resuming" if view.stopped else f"blocked in {blocked_at:.1f} m"
    if place.skips_corner:
        why += "; leaves out a corner of the route"
    return Avoid(
        detour.trajectory,
        begin=view.head.begin,
        rejoin=detour.rejoin,
        why=why,
        blocked_at=blocked_at or 0.0,
        guide_site=np.column_stack([detour.guide_site, height]),
    )
