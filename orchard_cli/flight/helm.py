"""From what was decided to what is streamed: when to stand, brake, join, follow and go back."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Points
from orchard_cli.model.mission import Mission
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import FlightMode, Setpoint, VehicleState
from orchard_cli.motion.situation import Stop, Verdict

from .guidance import Guidance
from .phases import Decision, Steer
from .trail import Trail

SPACING = 0.05  # m between points of an interrupted trajectory that is flown on
NEARBY = 400  # points ahead among which the point of rest is looked for


class Helm:
    """Owns the guidance, the trail home, and the rest of a route that was interrupted."""

    def __init__(self, mission: Mission) -> None:
        self.guidance = Guidance(mission.limits)
        self.trail = Trail()
        self._speed = mission.limits.speed
        self._rest = mission.trajectory  # still to be flown, should a join be asked for
        self._home: Trajectory | None = None
        self._steer = Steer.NOTHING

    def steer(self, decision: Decision, state: VehicleState, now: float) -> Setpoint | None:
        """The setpoint to stream, or None to stream nothing."""
        before, self._steer = self._steer, decision.steer
        if decision.steer is Steer.NOTHING:
            if before is not Steer.NOTHING:
                self._interrupt(now)
            return None
        engaged = state.mode is FlightMode.OFFBOARD
        if before is Steer.NOTHING or (not engaged and decision.steer is not Steer.FOLLOW):
            self.guidance.stand(state)
        if engaged:
            self._move(before, decision.steer, now)
            self.trail.add(state.position_site)
        return self.guidance.setpoint(now)

    def take(self, verdict: Verdict, commit: float, now: float) -> bool:
        """Fly what the avoidance system answered; False when it came too late."""
        before, stopped = self.guidance.active, self.guidance.blocked
        taken = self.guidance.take(verdict, commit, now)
        if taken and isinstance(verdict, Stop) and not stopped:
            self._remember(before, now)
        return taken

    def _move(self, before: Steer, steer: Steer, now: float) -> None:
        guidance, entered = self.guidance, before is not steer
        if steer is Steer.STAND and entered and not guidance.blocked:
            self._interrupt(now)
        elif steer is Steer.JOIN and guidance.still(now) and not guidance.pending:
            guidance.join(self._rest, now)
        elif steer is Steer.FOLLOW and guidance.pending:
            guidance.begin(now)
        elif steer is Steer.GO_BACK:
            self._go_back(now)

    def _go_back(self, now: float) -> None:
        guidance = self.guidance
        if guidance.reference is not None:
            if guidance.reference is self._home:
                return
            self._interrupt(now)
        if not guidance.still(now):
            return
        if not guidance.pending:
            guidance.join(guidance.timed(self.trail.home(guidance.position(now))), now)
        elif guidance.joined(now):
            self._home = guidance.begin(now)

    def _interrupt(self, now: float) -> None:
        before = self.guidance.active if self.guidance.reference is not None else None
        self.guidance.brake(now)
        self._remember(before, now)

    def _remember(self, before: Trajectory | None, now: float) -> None:
        """Keep what was left of `before` past the point of rest, timed anew from there."""
        if before is None or now >= before.end:
            return
        times = np.arange(now, before.end, SPACING / self._speed)
        ahead = before.sample(np.append(times, before.end))[0]
        rest = self.guidance.position(math.inf)
        nearest = int(np.argmin(np.linalg.norm(ahead[:NEARBY] - rest, axis=1)))
        left = _thinned(ahead[nearest:])
        if len(left) > 1:
            self._rest = self.guidance.timed(left)


def _thinned(points: Points) -> Points:
    """Without points that crowd where the curve was slow: their chords have no true direction."""
    travelled = np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))
    kept = np.flatnonzero(np.diff((travelled / SPACING).astype(int), prepend=0)) + 1
    thinned: Points = points[np.concatenate([[0], kept])]
    return thinned
