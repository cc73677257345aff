"""The `astar` system behind the avoidance socket (Huang 2021, §2.4 and §2.6)."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from orchard_cli.model.obstacles import Upright
from orchard_cli.model.sensors import Sensed
from orchard_cli.model.vehicle import Pose
from orchard_cli.motion.bends import SHARE
from orchard_cli.motion.braking import brake, brake_within
from orchard_cli.motion.course import Course
from orchard_cli.motion.room import Walk, first_met, samples
from orchard_cli.motion.situation import Avoid, Keep, Situation, Stop, Verdict
from orchard_cli.motion.stopwatch import Stopwatch
from orchard_cli.motion.view import View

from .legs import legs_round
from .room import Room, flat_room, high_room
from .search import Searcher
from .settings import AstarSettings

_CELL = 0.1  # m, of which half is added to the clearance
_PAST = 3.0  # m of path beyond the warning distance that are looked at


class Fusion(Protocol):
    """Radar and camera as one sensor."""

    needs: frozenset[str]  # sensors besides depth

    def look(self, sensed: Sensed, pose: Pose) -> tuple[Upright, ...]:
        """What the newest readings newly say stands ahead, seen from a pose of the body."""
        ...


class Astar:
    """Keeps the reference up to the warning distance; then legs between key turning points.

    Obstacles are what the map holds at the flight height and, where radar and camera are fitted,
    what their fusion found. Remembers that, and how far along the reference it is.
    """

    name = "astar"

    def __init__(self, settings: AstarSettings | None = None, fusion: Fusion | None = None) -> None:
        self._settings = settings or AstarSettings()
        self._fusion = fusion
        self.needs: frozenset[str] = frozenset() if fusion is None else fusion.needs
        self._searcher = Searcher()
        self._fused: tuple[Upright, ...] = ()
        self._progress = 0

    def plan(self, situation: Situation) -> Verdict:
        """Keep the active trajectory, go round what blocks it, or stop before it."""
        watch, s = Stopwatch(), self._settings
        with watch.stage("fuse"):
            self._look(situation)
        with watch.stage("distance_field"):
            warning = warning_distance(situation, s)
            view = View.of(situation, self._progress, warning + _PAST)
            self._progress = self._progress if view.stopped else view.first
            room = self._room(view)
        with watch.stage("check"):
            floor = situation.limits.clearance + room.cell / 2
            sees = view.stopped or _sees(view)
            close = _ahead(view, room, situation.now, floor + s.close, warning)
            blocked = _ahead(view, room, situation.commit, floor, warning)
        if not sees:
            halt = brake(situation.active, situation.commit, situation.limits.acceleration)
            return Stop(halt, "the camera has not looked where this leads", 0.0, watch.stages_ms)
        if close.blocked_at is None and not view.stopped:
            return Keep(stages_ms=watch.stages_ms)
        with watch.stage("search"):
            found = self._round(view, room, floor)
        verdict: Verdict
        if isinstance(found, Course):
            why = "resuming" if view.stopped else f"obstacle in {_far(close, floor):.1f} m"
            verdict = Avoid(
                found.trajectory, view.head.begin, found.rejoin, why, close.blocked_at or 0.0,
                found.guide_site,
            )  # fmt: skip
        elif view.stopped:
            verdict = Keep(f"stopped: {found}")
        else:
            verdict = self._stuck(view, blocked, found)
        return replace(verdict, stages_ms=watch.stages_ms)

    def _look(self, situation: Situation) -> None:
        """Remember what the fusion found; a newer look at the same thing replaces the older one."""
        if self._fusion is None:
            return
        pose = situation.frame_pose or situation.vehicle.pose
        seen = self._fusion.look(situation.sensed, pose)
        kept = tuple(
            old
            for old in self._fused
            if situation.now - old.time < self._settings.remember
            and not any(_same(old, new) for new in seen)
        )
        self._fused = kept + seen

    def _room(self, view: View) -> Room:
        s, situation = self._settings, view.situation
        path = view.ahead.points_site
        low, high = path.min(axis=0), path.max(axis=0)
        middle = (low + high)[:2] / 2
        reach = situation.limits.clearance + s.accept + max(a.cut for a in s.attempts) + 0.3
        if not s.three_d:
            heights = (float(low[2]) - s.below, float(high[2]) + s.above)
            return flat_room(situation.grid, self._fused, middle, s.half_size, heights, reach)
        corner = np.array([*(middle - s.half_size), low[2]])
        other = np.array([*(middle + s.half_size), high[2] + s.highest])
        stretch = situation.limits.clearance / s.vertical
        return high_room(situation.grid, self._fused, corner, other, stretch, reach)

    def _round(self, view: View, room: Room, floor: float) -> Course | str:
        """The first attempt that the limits and the map let be flown."""
        situation, why = view.situation, "no way was tried"
        if abs(view.head.interval - situation.reference.interval) > 1e-9:
            return "what is flown now is no part of the route"
        for how in self._settings.attempts:
            found = legs_round(view, room, self._searcher, how, floor, self._settings)
            if isinstance(found, Course):
                return found
            why = found
        return why

    def _stuck(self, view: View, blocked: Walk, why: str) -> Verdict:
        """No way past: brake before what blocks, as late as that is gentle."""
        s, situation = self._settings, view.situation
        if blocked.blocked_at is None:
            return Keep(f"close: {why}")
        active, most = situation.active, situation.limits.acceleration
        speed = float(np.linalg.norm(active.at(situation.commit).velocity_site))
        room = blocked.blocked_at - s.stop_short
        needed = speed**2 / (2 * s.gentle * most) + speed * active.interval
        if room > needed + 0.5:
            return Keep(why)  # there is time to look again
        halt = brake_within(active, situation.commit, max(room, 0.0), s.gentle * most, most)
        if not halt.fits:
            why = f"{why}; full braking does not end {s.stop_short} m before it"
        return Stop(halt.trajectory, why, max(room, 0.0))


def warning_distance(situation: Situation, s: AstarSettings) -> float:
    """m to an obstacle's surface at which it is acted on: as published, or what braking needs."""
    active, commit, limits = situation.active, situation.commit, situation.limits
    speed = float(np.linalg.norm(active.at(commit).velocity_site))
    late = commit - situation.now + 2 * active.interval
    stop = speed**2 / (2 * SHARE * limits.acceleration) + speed * late
    return max(s.warning, stop + limits.clearance + _CELL / 2 + s.accept + s.reserve)


def _ahead(view: View, room: Room, begin: float, floor: float, warning: float) -> Walk:
    """Along the active trajectory up to an obstacle at the warning distance."""
    situation = view.situation
    until = begin + 3 * (warning + _PAST) / situation.limits.speed
    places = samples(situation.active, begin, until)
    if len(places) == 0:
        return Walk(None, np.inf)
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    gone = np.concatenate([[0.0], np.cumsum(steps)])
    places = places[gone <= max(warning - floor, 0.0)]
    return first_met(places, room.at(places), floor)


def _sees(view: View) -> bool:
    situation = view.situation
    active, commit = situation.active, situation.commit
    soon = active.at(min(commit + active.interval, active.end)).velocity_site
    return view.sight.looks_ahead(active, commit, float(np.linalg.norm(soon)))


def _far(walk: Walk, floor: float) -> float:
    return (walk.blocked_at or 0.0) + floor


def _same(a: Upright, b: Upright) -> bool:
    apart = float(np.hypot(*(a.centre_site - b.centre_site)))
    return apart < max(1.0, (a.width + b.width) / 2)
