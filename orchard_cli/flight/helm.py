"""From what was decided to what is streamed: when to stand, brake, join, follow and go back."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from orchard_cli.model.arrays import Points
from orchard_cli.model.mission import Mission
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import FlightMode, Setpoint, VehicleState
from orchard_cli.motion.situation import Stop, Verdict
from orchard_cli.motion.yaw import STEADY, YawRule

from .emergency import HARD
from .guidance import Guidance
from .safety import Hazard
from .stage import Decision, Steer
from .trail import HAIR, Trail
from .worker import Worker

SPACING = 0.05  # m between points of an interrupted trajectory that is flown on
NOTHING = 1e-3  # m of route that need not be flown any more
NEARBY = 400  # points ahead among which the point of rest is looked for

Errand = Callable[[], Trajectory]


class Helm:
    """Owns the guidance, the trail home, and the rest of a route that was interrupted.

    Timing a long path takes a good part of a second, so it is an errand, done beside the loop
    while the vehicle stands.
    """

    def __init__(
        self, mission: Mission, errands: Worker[Errand, Trajectory], yaw_rule: YawRule = STEADY
    ) -> None:
        self.guidance = Guidance(mission.limits, yaw_rule)
        self.trail = Trail()
        self._speed = mission.limits.speed
        self._mission = mission.trajectory
        self._errands = errands
        self._asked: str | None = None  # the errand under way
        self._left: Points | None = None  # of an interrupted route, from its point of rest on
        self._on_route = False
        self._homing = False
        self._steer = Steer.NOTHING
        self._cause: Hazard | None = None

    def steer(self, decision: Decision, state: VehicleState, now: float) -> Setpoint | None:
        """The setpoint to stream, or None to stream nothing."""
        before, self._steer = self._steer, decision.steer
        cause, self._cause = self._cause, decision.stage.cause
        if decision.steer is Steer.NOTHING:
            if before is not Steer.NOTHING:
                self._interrupt(now)
            return None
        engaged = state.mode is FlightMode.OFFBOARD
        if before is Steer.NOTHING or (not engaged and decision.steer is not Steer.FOLLOW):
            self.guidance.stand(state)
            self._on_route = False
        if engaged:
            changed = before is not decision.steer or cause is not self._cause
            self._move(decision, changed, now)
            if not self._homing:
                self.trail.add(state.position_site)
        return self.guidance.setpoint(now)

    def take(self, verdict: Verdict, commit: float, now: float) -> bool:
        """Fly what the avoidance system answered; False when it came too late.

        While held for another cause than an obstacle, no answer sets the vehicle in motion.
        """
        if self._steer is Steer.STAND and self._cause is not Hazard.BLOCKED:
            return True
        before, stopped = self.guidance.active, self.guidance.blocked
        taken = self.guidance.take(verdict, commit, now)
        if taken and isinstance(verdict, Stop) and not stopped and self._on_route:
            self._remember(before, now)
        return taken

    def _move(self, decision: Decision, changed: bool, now: float) -> None:
        guidance, steer = self.guidance, decision.steer
        if steer is Steer.STAND:
            if changed and self._cause is not Hazard.BLOCKED:
                self._interrupt(now)
        elif steer is Steer.JOIN:
            self._join("route", self._route, now)
        elif steer is Steer.FOLLOW and guidance.pending:
            guidance.begin(now)
            self._on_route = True
        elif steer is Steer.GO_BACK:
            self._go_back(now)
        elif steer is Steer.DIVERT and decision.stage.place_site is not None:
            self._divert(decision.stage.place_site, changed, now)

    def _go_back(self, now: float) -> None:
        if not self._homing:
            self._interrupt(now)
            self._homing = True
        self._join("home", self._home, now)
        if self.guidance.joined(now):
            self.guidance.begin(now)

    def _divert(self, place_site: tuple[float, float], begins: bool, now: float) -> None:
        if begins:
            self._interrupt(now)
        self._join("haven", lambda: self._straight(place_site), now)
        if self.guidance.joined(now):
            self.guidance.begin(now)

    def _join(self, name: str, make: Callable[[], Errand], now: float) -> None:
        """Once standing: have the path timed, then go to its start leg by leg."""
        guidance = self.guidance
        if guidance.pending:
            guidance.advance(now)
        elif guidance.reference is None and guidance.still(now):
            route = self._done(name, make, now)
            if route is not None:
                guidance.join(route, now)

    def _done(self, name: str, make: Callable[[], Errand], now: float) -> Trajectory | None:
        result = self._errands.take(now)
        if self._asked == name and isinstance(result, Exception):
            raise result
        if self._asked == name and isinstance(result, Trajectory):
            self._asked = None
            return result
        if self._asked != name and self._errands.idle():
            self._asked = name
            self._errands.give(make(), now)
        return None

    def _route(self) -> Errand:
        left = self._left
        if left is None:
            return lambda: self._mission
        return lambda: self.guidance.timed(left)

    def _home(self) -> Errand:
        path = self.trail.home(self.guidance.position(math.inf))
        return lambda: self.guidance.timed(path)

    def _straight(self, place_site: tuple[float, float]) -> Errand:
        here = self.guidance.position(math.inf)
        path = np.stack([here, np.array([*place_site, here[2]])])
        return lambda: self.guidance.timed(path)

    def _interrupt(self, now: float) -> None:
        route = self._on_route and not self.guidance.blocked
        before = self.guidance.active if route else None
        self.guidance.brake(now, HARD if self._cause is Hazard.OBSTACLE else None)
        self._on_route = False
        self._asked = None  # what is being timed is for another place
        self._remember(before, now)

    def _remember(self, before: Trajectory | None, now: float) -> None:
        """Keep what was left of `before` past the point of rest."""
        if before is None or now >= before.end:
            return
        times = np.arange(now, before.end, SPACING / self._speed)
        ahead = before.sample(np.append(times, before.end))[0]
        rest = self.guidance.position(math.inf)
        nearest = int(np.argmin(np.linalg.norm(ahead[:NEARBY] - rest, axis=1)))
        left = _thinned(np.concatenate([rest[None], ahead[nearest + 1 :]]))
        if len(left) > 1:
            done = np.ptp(left, axis=0).max() < NOTHING
            self._left = np.stack([rest, rest + HAIR]) if done else left


def _thinned(points: Points) -> Points:
    """Without points that crowd where the curve was slow: their chords have no true direction.

    The first and the last point stay.
    """
    travelled = np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))
    kept = np.flatnonzero(np.diff((travelled / SPACING).astype(int), prepend=0)) + 1
    kept = np.concatenate([[0], kept[kept < len(points) - 1][:-1], [len(points) - 1]])
    thinned: Points = points[kept]
    return thinned
