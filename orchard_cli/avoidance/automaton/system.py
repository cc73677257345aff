"""The `dfa` system: the automaton of Ahmed 2022 between sensors and trajectories.

The automaton says which velocity to fly (states.py); here that becomes a trajectory that joins the
active one at the commit time and keeps the vehicle's limits, and the way back onto the route.
Not in the paper, and added so that a machine may fly it among people: it stops when the way
sideways or forwards is not free, when the sensors fall silent, when an obstacle has no end
within reach, and when it has lost what it slowed down for it goes on.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from orchard_cli.model.trajectory import Trajectory
from orchard_cli.motion.braking import brake
from orchard_cli.motion.situation import Avoid, Keep, Situation, Stop, Verdict
from orchard_cli.motion.stopwatch import Stopwatch

from .course import WayBack, back_to_route, steered
from .guard import FORWARD, LONGEST, SIDEWAYS, refusal
from .manoeuvre import MARGIN, Manoeuvre, begun, beside_the_line, trigger_of_q5
from .numbers import AutomatonSettings, arm, numbers, safe_distance
from .states import S1, S2, S3, S4, Memory, Numbers, Reading, State, advance, velocity
from .view import STALE, View

LASTING = 4.0  # s that a commanded velocity is flown without being commanded again, and
RENEWED = 1.5  # s of it that are left when it is
LOST = 1.0  # s without the obstacle after which it was none
ON_LINE = 0.3  # m beside the route up to which the radar ahead sees the way on, and
UNSEEN = 2.0  # safe distances of a way that the radar, ahead, does not see when it begins
CLEAR = 1.0  # s without anything in the way before it goes on from a stop
SAME = 0.02  # m/s by which a command may differ from what is flown: the tank empties


class Dfa:
    """Slows down, passes at the safe distance on velocity commands, and returns to its line."""

    name = "dfa"
    needs = frozenset({"radar", "range"})

    def __init__(self, settings: AutomatonSettings | None = None) -> None:
        self.settings = settings or AutomatonSettings()
        self._view = View()
        self._memory = Memory()
        self._flown: Manoeuvre | None = None
        self._active: Trajectory | None = None  # of ours, being flown
        self._offered: Trajectory | None = None  # last; it may come too late to be flown
        self._back: WayBack | None = None  # offered last, to be back on the route
        self._stop: Trajectory | None = None  # offered last, to be at rest
        self._delay = 0.0  # s by which what is flown is behind the reference
        self._reference: Trajectory | None = None
        self._seen = -math.inf  # s, when something was last in the way

    @classmethod
    def wide(cls) -> Dfa:
        """With a safe distance of four arms: 2 m for the paper's sprayer (its Fig. 16)."""
        return cls(AutomatonSettings(safe_arms=4.0))

    def plan(self, situation: Situation) -> Verdict:
        """One look, one step of the automaton, and the trajectory that it asks for."""
        watch = Stopwatch()
        with watch.stage("sense"):
            self._view.look(situation)
            self._recall(situation)
            sizes = self._numbers(situation)
            reading = self._read(situation)
        with watch.stage("decide"):
            verdict = self._decide(situation, reading, sizes)
        return replace(verdict, stages_ms=watch.stages_ms)

    def _recall(self, situation: Situation) -> None:
        """See which offer was taken, and forget a manoeuvre that is not being flown."""
        active, reference = situation.active, situation.reference
        taken = self._offered is not None and active is self._offered
        if reference is not self._reference or not (taken or active is self._active):
            self._forget(situation.now)
            self._reference, self._delay, self._back = reference, 0.0, None
        elif self._back is not None and active is self._back.trajectory and taken:
            if self._active is not active:  # since this cycle
                self._delay = self._back.delay
                self._forget(situation.now)
        elif not taken and self._flown is not None:
            self._flown.command = None  # what was asked for is not flown: ask again
        self._active = active

    def _forget(self, now: float) -> None:
        self._memory, self._flown, self._stop = Memory(now=now), None, None

    def _numbers(self, situation: Situation) -> Numbers:
        speed = float(np.linalg.norm(situation.active.at(situation.commit).velocity_site))
        return numbers(self.settings, situation.limits, situation.load, speed)

    def _width(self, situation: Situation) -> float:
        return safe_distance(self.settings, situation.limits, situation.load) + MARGIN

    def _read(self, situation: Situation) -> Reading:
        flown = self._flown
        if flown is None:
            yaw = situation.vehicle.yaw_site
            facing = np.array([math.cos(yaw), math.sin(yaw)])
            return self._view.reading(situation, self._width(situation), facing, None)
        found = self._view.obstacle(situation, self._width(situation), flown.facing)
        if self._memory.state is State.Q1 and found is not None:
            flown.obstacle = found
        seen = self._view.reading(situation, self._width(situation), flown.facing, flown.obstacle)
        return beside_the_line(flown, situation, self.settings, seen)

    def _decide(self, situation: Situation, reading: Reading, sizes: Numbers) -> Verdict:
        if reading.ahead < math.inf:
            self._seen = situation.now
        if self._view.age(situation.now) > STALE:
            return self._halt(situation, "the radar or the lasers are silent", 0.0)
        if situation.active is self._stop:
            return self._wait(situation, reading, sizes)
        return self._move(situation, reading, sizes)

    def _move(self, situation: Situation, reading: Reading, sizes: Numbers) -> Verdict:
        """Step the automaton, and fly what its state asks for."""
        before = self._memory.state
        sizes = self._timed(situation, sizes)
        self._memory = advance(self._memory, reading, sizes, situation.now)
        self._help_small_things(situation, reading)
        state = self._memory.state
        if state is State.Q0 and before is State.Q0 and self._flown is None:
            return Keep(blocked_at=None if math.isinf(reading.ahead) else reading.ahead)
        if before is State.Q0 and state is State.Q1:
            self._begin(situation)
        if state is State.Q1 and situation.now - self._seen > LOST:
            return self._return(situation, "what was in the way is gone")
        if state is State.Q0:
            return self._return(situation, "passed")
        assert self._flown is not None
        why = refusal(self._memory, self._flown, situation, reading, self.settings, self._view)
        if why:
            return self._halt(situation, why, reading.ahead)
        return self._steer(situation, reading, sizes)

    def _timed(self, situation: Situation, sizes: Numbers) -> Numbers:
        """With the trigger time of q5 as it was when that began."""
        flown, memory = self._flown, self._memory
        if flown is None or memory.state not in (State.Q3, State.Q4, State.Q5):
            return sizes
        if memory.state is not State.Q5:
            flown.trigger = trigger_of_q5(
                flown, memory, situation, self.settings, sizes, self._view
            )
        return sizes if flown.trigger is None else replace(sizes, trigger=flown.trigger)

    def _begin(self, situation: Situation) -> None:
        found = self._view.obstacle(situation, self._width(situation))
        self._flown = begun(situation, found, self._delay)

    def _steer(self, situation: Situation, reading: Reading, sizes: Numbers) -> Verdict:
        """Fly the state's velocity; nothing new while that is what is flown."""
        flown = self._flown
        assert flown is not None
        command = velocity(self._memory, sizes)
        why = f"{self._memory.state.name.lower()}: {self._memory.state.value}"
        near = 0.0 if math.isinf(reading.ahead) else reading.ahead
        running = situation.active.end - situation.commit
        same = flown.command is not None and np.allclose(flown.command, command, atol=SAME)
        if same and running > RENEWED + self._braking(situation):
            return Keep(why, near)
        flown.command = command
        made = self._commanded(situation, command)
        self._offered = made
        return Avoid(made, situation.commit, made.end, why, near, yaw_site=flown.yaw)

    def _commanded(self, situation: Situation, command: tuple[float, float]) -> Trajectory:
        """From the commit time on at a velocity (forward, right), m/s."""
        flown = self._flown
        assert flown is not None
        (forward, right), (x, y) = command, flown.facing
        wanted = np.array([forward * x + right * y, forward * y - right * x, forward * flown.slope])
        span = (situation.now, situation.commit)
        return steered(situation.active, span, wanted, situation.limits.acceleration, LASTING)

    def _braking(self, situation: Situation) -> float:
        """s from the present speed to rest."""
        speed = float(np.linalg.norm(situation.active.at(situation.commit).velocity_site))
        return speed / situation.limits.acceleration

    def _return(self, situation: Situation, why: str, margin: float = 0.0) -> Verdict:
        """Onto the route, from where it passes the vehicle; `margin`: m more than the airframe that
        must be free beside the way."""
        onto = self._abreast(situation)
        way = back_to_route(
            situation.active,
            situation.reference,
            (situation.now, situation.commit),
            onto,
            situation.limits.acceleration,
        )
        if way is None:
            return self._halt(situation, "no way back onto the route", 0.0)
        near = self._view.near(way.trajectory, way.begin, UNSEEN * self._width(situation))
        if near < situation.limits.airframe_radius + margin:
            return self._halt(situation, "something stands on the way back", 0.0)
        yaw = None if self._flown is None else self._flown.yaw
        self._back, self._offered = way, way.trajectory
        return Avoid(way.trajectory, way.begin, way.rejoin, why, 0.0, yaw_site=yaw)

    def _abreast(self, situation: Situation) -> float:
        """s on the reference's clock: where it first comes level with the vehicle, or nearest to it
        before it turns away."""
        reference, flown = situation.reference, self._flown
        here = situation.active.at(situation.commit).position_site
        if flown is None:
            return min(max(situation.now - self._delay, reference.start), reference.end)
        times = flown.onto + np.arange(0.0, LONGEST / situation.limits.speed + 4.0, 0.05)
        times = times[times <= reference.end]
        if not len(times):
            return reference.end
        along = (reference.sample(times)[0][:, :2] - here[:2]) @ flown.facing
        level = np.flatnonzero(along >= 0.0)
        if len(level):
            return float(times[level[0]])
        turned = np.flatnonzero(np.diff(along) < 0.0)
        return float(times[turned[0] if len(turned) else -1])

    def _help_small_things(self, situation: Situation, reading: Reading) -> None:
        """A thin pole may slip between two shots of a laser: well past where the radar saw it, with
        nothing beside, it counts as met."""
        flown, memory = self._flown, self._memory
        side = {State.Q6: S2, State.Q7: S4}.get(memory.state)
        if flown is None or side is None or memory.touched(side):
            return
        here = situation.active.at(situation.now).position_site
        past = flown.ahead_of(here) - flown.ahead_of(flown.obstacle)
        reach = arm(situation.limits, situation.load)
        if past > 2 * reach + self._width(situation) and math.isinf(reading.lasers[side]):
            a, b, c, d = (0.0 if k == side else far for k, far in enumerate(memory.nearest))
            self._memory = replace(memory, nearest=(a, b, c, d))

    def _halt(self, situation: Situation, why: str, near: float) -> Verdict:
        """Brake along what is flown."""
        near = 0.0 if math.isinf(near) else near
        if situation.active is self._stop:
            return Keep(f"stopped: {why}", near)
        if self._flown is None:
            self._begin(situation)
        braked = brake(situation.active, situation.commit, situation.limits.acceleration)
        self._stop = self._offered = braked
        return Stop(braked, why, near)

    def _wait(self, situation: Situation, reading: Reading, sizes: Numbers) -> Verdict:
        """At rest: go on when the way ahead has been free for a while."""
        passed = situation.now - self._memory.now
        self._memory = replace(self._memory, now=situation.now, since=self._memory.since + passed)
        rest = situation.now >= situation.active.end
        if self._memory.state in SIDEWAYS + FORWARD:
            return self._resume(situation, reading, sizes, rest)
        lasers = min(reading.lasers[S1], reading.lasers[S3])
        there = situation.reference.at(self._abreast(situation)).position_site
        aside = float(np.linalg.norm(situation.active.at(situation.now).position_site - there))
        if aside > ON_LINE:
            return Keep(f"stopped {aside:.1f} m beside the route: nothing sees the way back", 0.0)
        if rest and situation.now - self._seen > CLEAR and math.isinf(lasers):
            return self._return(situation, "the way is free again", MARGIN)
        return Keep("stopped: the way is not free", 0.0)

    def _resume(
        self, situation: Situation, reading: Reading, sizes: Numbers, rest: bool
    ) -> Verdict:
        """At rest in a manoeuvre: fly on in it when what stopped it has been gone for a while."""
        flown = self._flown
        assert flown is not None
        made = self._commanded(situation, velocity(self._memory, sizes))
        length = UNSEEN * self._width(situation)
        near = self._view.near(made, situation.commit, length)
        free = near > situation.limits.airframe_radius + MARGIN and not refusal(
            self._memory, flown, situation, reading, self.settings, self._view
        )
        if not (rest and free):
            flown.blocked = situation.now
        if situation.now - flown.blocked < CLEAR:
            return Keep("stopped: the way is not free", 0.0)
        flown.command, self._stop = None, None
        return self._steer(situation, reading, sizes)
