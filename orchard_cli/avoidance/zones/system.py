"""The `zones` system behind the avoidance socket: eyes, then a decision, then a trajectory."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from orchard_cli.model.arrays import Points
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.obstacles import Category, Sighting
from orchard_cli.model.sensors import ColourFrame
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import Pose
from orchard_cli.motion.braking import brake, brake_within
from orchard_cli.motion.course import Course, course, rejoin_at
from orchard_cli.motion.room import Walk, walk
from orchard_cli.motion.situation import Avoid, Keep, Situation, Stop, Verdict
from orchard_cli.motion.stopwatch import Stopwatch
from orchard_cli.motion.view import View

from .decide import ALIVE, Act, Decision, ahead_on, decide
from .manoeuvre import points_past
from .settings import ZonesSettings
from .tracks import Track, follow

_STEADY = (1.5, 4.0)  # s after the commit time between which the speed tells whether it is slow
_PAST = 4.0  # m of path beyond the warning distance that are looked at


class Eyes(Protocol):
    """Finds the obstacles in a frame."""

    needs: frozenset[str]  # sensors besides depth

    def look(self, frame: DepthFrame, pose: Pose, colour: ColourFrame | None) -> Sighting:
        """Everything seen in a depth frame that was taken at a pose of the body."""
        ...


class Zones:
    """Slows, turns, leaps or hovers by what the obstacle is and how near (Wang 2020).

    The paper's decision proposes; the map disposes: a trajectory that comes too near to an occupied
    cell is not flown. Remembers what was seen, and how far along the reference it is.
    """

    name = "zones"

    def __init__(self, eyes: Eyes, settings: ZonesSettings | None = None) -> None:
        self._eyes = eyes
        self.needs = eyes.needs
        self._settings = settings or ZonesSettings()
        self._tracks: tuple[Track, ...] = ()
        self._reference: Trajectory | None = None
        self._progress = 0  # the reference's knot reached when last on it
        self._slowed: Trajectory | None = None  # offered last, to slow down

    def plan(self, situation: Situation) -> Verdict:
        """Keep the active trajectory, slow down, go past what is ahead, or hover."""
        watch, s = Stopwatch(), self._settings
        with watch.stage("detect"):
            pose = situation.frame_pose or situation.vehicle.pose
            sighting = self._eyes.look(situation.frame, pose, situation.sensed.colour)
            self._tracks = follow(self._tracks, sighting.obstacles, situation.now, s.forget)
        with watch.stage("check"):
            if situation.reference is not self._reference:
                self._reference, self._progress = situation.reference, 0
            view = View.of(situation, self._progress, s.warning + _PAST)
            self._progress = self._progress if view.stopped else view.first
            decision = self._decide(view, sighting)
            met = self._walk(view, situation.now)
        with watch.stage("replan"):
            verdict = self._act(view, decision, met.blocked_at)
        return replace(
            verdict, stages_ms=watch.stages_ms, alarm=_alarm(decision), alive=_alive(decision)
        )

    def _decide(self, view: View, sighting: Sighting) -> Decision:
        s, limits = self._settings, view.situation.limits
        known = [ahead_on(view.ahead, t.obstacle) for t in self._tracks if t.looks >= s.confirmed]
        return decide(known, self._glimpsed(view, sighting), limits.clearance, s)

    def _glimpsed(self, view: View, sighting: Sighting) -> Category | None:
        """What is seen in the way without its distance: its box hides the passing area at the
        warning distance."""
        s, camera = self._settings, view.situation.frame.camera
        yaw, course_ = view.situation.vehicle.yaw_site, view.ahead.direction(0.0)
        ahead = float(course_ @ np.array([np.cos(yaw), np.sin(yaw)]))
        left = float(course_ @ np.array([-np.sin(yaw), np.cos(yaw)]))
        if ahead <= 0.0:
            return None
        u, half = camera.cx - camera.fx * left / ahead, camera.fx * s.half / s.warning
        for one in sighting.glimpses:
            across = one.left < u + half and one.right > u - half
            if across and one.top < camera.cy + half and one.bottom > camera.cy - half:
                return one.category
        return None

    def _act(self, view: View, decision: Decision, blocked_at: float | None) -> Verdict:
        if decision.act is Act.HOVER:
            return self._hover(view, decision)
        if not view.stopped and not self._sees(view):
            situation = view.situation
            halt = brake(situation.active, situation.commit, situation.limits.acceleration)
            return Stop(halt, "the camera has not looked where this leads", 0.0)
        found: Avoid | str = decision.why
        if decision.act is Act.AVOID:
            found = self._past(view, decision)
        elif view.stopped:
            found = self._resume(view)
        elif blocked_at is not None:
            found = "the map shows what was not recognised" if decision.ahead is None else found
        elif decision.act is Act.SLOW_DOWN and not self._is_slow(view):
            found = self._slow(view, decision)
            self._slowed = found.trajectory if isinstance(found, Avoid) else None
        if isinstance(found, Avoid):
            return found
        if decision.act is Act.AVOID or blocked_at is not None or view.stopped:
            return self._stuck(view, decision, found)
        return Keep(found)

    def _hover(self, view: View, decision: Decision) -> Verdict:
        """Stop at once."""
        why = f"{decision.zone.value} zone: {decision.why}"
        if view.stopped:
            return Keep(f"hovering, {why}")
        situation = view.situation
        halt = brake(situation.active, situation.commit, situation.limits.acceleration)
        return Stop(halt, why, _near(decision))

    def _past(self, view: View, decision: Decision) -> Avoid | str:
        """Past what is ahead by the first way and speed that the map and the limits allow."""
        s, one, why = self._settings, decision.ahead, "there is no way past"
        if one is None:
            return why
        for way in decision.ways:
            points = points_past(view.ahead, one, way, view.begin, view.situation.limits, s)
            if isinstance(points, str):
                why = f"{way.value}: {points}"
                continue
            for cruise in s.cruises:
                found = self._tried(view, points, cruise)
                if isinstance(found, Course):
                    return _avoid(view, found, f"{decision.why}: {way.value}", _near(decision))
                why = f"{way.value}: {found}"
        return f"{decision.why}: {why}"

    def _resume(self, view: View) -> Avoid | str:
        """From where it stands back onto the route."""
        why = ""
        for cruise in self._settings.cruises:
            found = self._tried(view, np.empty((0, 3)), cruise)
            if isinstance(found, Course):
                return _avoid(view, found, "resuming", 0.0)
            why = found
        return why

    def _slow(self, view: View, decision: Decision) -> Avoid | str:
        """The same path, slower up to the obstacle."""
        s, situation = self._settings, view.situation
        far = s.warning if decision.ahead is None else decision.ahead.along
        begin = view.begin
        path = np.stack(
            [view.ahead.at(x) for x in np.arange(begin + 0.5, max(far, begin + 3), 0.5)]
        )
        rejoin = rejoin_at(situation.reference, view.first, path[-1], s.lead)
        found = course(
            view.head, path, situation.reference, view.first, rejoin, s.slow, situation.limits
        )
        if isinstance(found, str):
            return found
        return _avoid(view, found, f"{decision.zone.value} zone: {decision.why}", far)

    def _tried(self, view: View, corners: Points, cruise: float) -> Course | str:
        """A course through corners (n, 3) m that the map finds free."""
        s, situation = self._settings, view.situation
        last, lead = view.head.control_points_site[-1], 2 * s.lead
        if len(corners):
            last, lead = corners[-1], s.lead
        rejoin = rejoin_at(situation.reference, view.first, last, lead)
        found = course(
            view.head, corners, situation.reference, view.first, rejoin, cruise, situation.limits
        )
        if isinstance(found, str):
            return found
        met = walk(
            situation.grid, found.trajectory, view.head.begin, found.rejoin + 1.0,
            situation.limits, s.vertical, s.accept,
        )  # fmt: skip
        if met.blocked_at is not None:
            return f"comes within {met.clearance:.2f} m of what the map shows"
        if view.stopped and not view.sight.looks_ahead(
            found.trajectory, view.head.begin, cruise * situation.limits.speed
        ):
            return "the camera has not looked where it leads"
        return found

    def _stuck(self, view: View, decision: Decision, why: str) -> Verdict:
        """No way past: brake before what blocks, as late as that is gentle."""
        s, situation = self._settings, view.situation
        if view.stopped:
            return Keep(f"stopped: {why}")
        active, most = situation.active, situation.limits.acceleration
        soon = active.at(situation.commit)
        speed = float(np.linalg.norm(soon.velocity_site))
        left = self._walk(view, situation.commit)
        room = np.inf if left.blocked_at is None else left.blocked_at - s.stop_short
        if decision.act is Act.AVOID:
            gone = view.ahead.beside(soon.position_site)[0]
            room = min(room, _near(decision) - gone - s.emergency)
        needed = speed**2 / (2 * s.gentle * most) + speed * active.interval
        if room > needed + 0.5:
            return Keep(why)  # there is time to look again
        halt = brake_within(active, situation.commit, max(room, 0.0), s.gentle * most, most)
        if not halt.fits:
            why = f"{why}; full braking does not end before it"
        return Stop(halt.trajectory, why, max(room, 0.0))

    def _walk(self, view: View, begin: float) -> Walk:
        """Along the active trajectory through the map."""
        s, situation = self._settings, view.situation
        until = situation.now + s.look_ahead / situation.limits.speed
        return walk(situation.grid, situation.active, begin, until, situation.limits, s.vertical)

    def _sees(self, view: View) -> bool:
        situation = view.situation
        active, commit = situation.active, situation.commit
        soon = active.at(min(commit + active.interval, active.end)).velocity_site
        return view.sight.looks_ahead(active, commit, float(np.linalg.norm(soon)))

    def _is_slow(self, view: View) -> bool:
        situation = view.situation
        if situation.active is self._slowed:
            return True
        times = situation.commit + np.linspace(*_STEADY, 6)
        speeds = np.linalg.norm(situation.active.sample(times)[1], axis=1)
        return bool(speeds.max() <= 1.2 * self._settings.slow * situation.limits.speed)


def _alarm(decision: Decision) -> str:
    """Without the distance, which changes with every look."""
    if not decision.alarm or decision.ahead is None:
        return ""
    what = decision.ahead.obstacle.category.value
    return f"{what} ahead in the {decision.zone.value} zone: hovering"


def _alive(decision: Decision) -> bool:
    """A person or a drone is near enough to hover."""
    ahead = decision.ahead
    return decision.alarm and ahead is not None and ahead.obstacle.category in ALIVE


def _near(decision: Decision) -> float:
    return 0.0 if decision.ahead is None else max(decision.ahead.near, 0.0)


def _avoid(view: View, found: Course, why: str, blocked_at: float) -> Avoid:
    return Avoid(found.trajectory, view.head.begin, found.rejoin, why, blocked_at, found.guide_site)
