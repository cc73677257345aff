"""The `dfa` system: the automaton of Ahmed 2022 between sensors and trajectories.

The automaton says which velocity to fly (states.py); here that becomes a trajectory that joins the
active one at the commit time and keeps the vehicle's limits, and the way back onto the route.
Not in the paper, and added so that a machine may fly it among people: it stops when the way
sideways or forwards is not free, when the sensors fall silent, when an obstacle has no end
within reach, and when it has lost what it slowed down for it goes on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.motion.braking import brake
from orchard_cli.motion.situation import Avoid, Keep, Situation, Stop, Verdict
from orchard_cli.motion.stopwatch import Stopwatch

from .course import WayBack, back_to_route, steered
from .numbers import ALPHA, AutomatonSettings, arm, numbers, safe_distance, trigger_time
from .states import S1, S2, S3, S4, Memory, Numbers, Reading, State, advance, velocity
from .view import STALE, View

LASTING = 4.0  # s that a commanded velocity is flown without being commanded again, and
RENEWED = 1.5  # s of it that are left when it is
WIDEST = 15.0  # m that it flies sideways to find an obstacle's end, and
LONGEST = 40.0  # m forward along it
LOST = 1.0  # s without the obstacle after which it was none
MARGIN = 0.15  # m beside the safe distance in which things count: what the radar is worth
ON_LINE = 0.3  # m beside the route up to which the radar ahead sees the way on, and
CLEAR = 1.0  # s without anything in the way before it goes on from a stop
SAME = 0.02  # m/s by which a command may differ from what is flown: the tank empties
SIDEWAYS = (State.Q3, State.Q4, State.Q5, State.Q9, State.Q10)
FORWARD = (State.Q6, State.Q7, State.Q8)


@dataclass(slots=True, eq=False)
class _Manoeuvre:
    """One avoidance, from the slowing down to the way back."""

    facing: Vector  # (2,) unit: forward, along the route where it began
    slope: float  # m up per m forward
    yaw: float  # rad, held
    began: Vector  # (3,) m
    onto: float  # s on the reference's clock, where it began
    obstacle: Vector  # (3,) m
    command: tuple[float, float] | None = None
    trigger: float | None = None  # s, of q5: fixed when it begins


class Dfa:
    """Slows down, passes at the safe distance on velocity commands, and returns to its line."""

    name = "dfa"
    needs = frozenset({"radar", "range"})

    def __init__(self, settings: AutomatonSettings | None = None) -> None:
        self.settings = settings or AutomatonSettings()
        self._view = View()
        self._memory = Memory()
        self._flown: _Manoeuvre | None = None
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
        else:
            facing = flown.facing
        return self._view.reading(situation, self._width(situation), facing)

    def _decide(self, situation: Situation, reading: Reading, sizes: Numbers) -> Verdict:
        if reading.ahead < math.inf:
            self._seen = situation.now
        if self._view.age(situation.now) > STALE:
            return self._halt(situation, "the radar or the lasers are silent", 0.0)
        if situation.active is self._stop:
            return self._wait(situation, reading)
        return self._move(situation, reading, sizes)

    def _move(self, situation: Situation, reading: Reading, sizes: Numbers) -> Verdict:
        """Step the automaton, and fly what its state asks for."""
        before = self._memory.state
        sizes = self._timed(situation, reading, sizes)
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
        why = self._not_free(situation, reading)
        if why:
            return self._halt(situation, why, reading.ahead)
        return self._steer(situation, reading, sizes)

    def _timed(self, situation: Situation, reading: Reading, sizes: Numbers) -> Numbers:
        """With the trigger time of q5 for the gap there is and the speed aside there is."""
        flown, memory = self._flown, self._memory
        if flown is None or memory.state not in (State.Q3, State.Q4, State.Q5):
            return sizes
        if memory.state is not State.Q5:
            gap = arm(situation.limits, situation.load) * math.cos(ALPHA)
            met = memory.touched(S1 if memory.state is State.Q3 else S3)
            if not met and not math.isnan(reading.aside):
                gap = max(gap, abs(reading.aside))
            moved = situation.active.at(situation.commit).velocity_site
            aside = abs(float(flown.facing[0] * moved[1] - flown.facing[1] * moved[0]))
            left = safe_distance(self.settings, situation.limits, situation.load) - gap
            share = min(aside / sizes.speed, 1.0)
            flown.trigger = trigger_time(self.settings, left, share, sizes.speed)
        return sizes if flown.trigger is None else replace(sizes, trigger=flown.trigger)

    def _begin(self, situation: Situation) -> None:
        state = situation.active.at(situation.commit)
        ahead = state.velocity_site[:2]
        speed = float(np.linalg.norm(ahead))
        yaw = situation.vehicle.yaw_site
        facing = ahead / speed if speed > 0.2 else np.array([math.cos(yaw), math.sin(yaw)])
        found = self._view.obstacle(situation, self._width(situation))
        self._flown = _Manoeuvre(
            facing=facing,
            slope=float(state.velocity_site[2]) / speed if speed > 0.2 else 0.0,
            yaw=math.atan2(float(facing[1]), float(facing[0])),
            began=state.position_site,
            onto=min(situation.now - self._delay, situation.reference.end),
            obstacle=state.position_site if found is None else found,
        )

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
        forward, right = command
        x, y = flown.facing
        wanted = np.array([forward * x + right * y, forward * y - right * x, forward * flown.slope])
        span = (situation.now, situation.commit)
        made = steered(situation.active, span, wanted, situation.limits.acceleration, LASTING)
        self._offered = made
        return Avoid(made, situation.commit, made.end, why, near, yaw_site=flown.yaw)

    def _braking(self, situation: Situation) -> float:
        """s from the present speed to rest."""
        speed = float(np.linalg.norm(situation.active.at(situation.commit).velocity_site))
        return speed / situation.limits.acceleration

    def _return(self, situation: Situation, why: str) -> Verdict:
        """Onto the route, from where it passes the vehicle."""
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
        past = float((here - flown.obstacle)[:2] @ flown.facing)
        reach = arm(situation.limits, situation.load)
        if past > 2 * reach + self._width(situation) and math.isinf(reading.lasers[side]):
            a, b, c, d = (0.0 if k == side else far for k, far in enumerate(memory.nearest))
            self._memory = replace(memory, nearest=(a, b, c, d))

    def _not_free(self, situation: Situation, reading: Reading) -> str:
        """Why the commanded way must not be flown; empty: it may."""
        state, flown = self._memory.state, self._flown
        assert flown is not None
        speed = float(np.linalg.norm(situation.active.at(situation.commit).velocity_site))
        stopping = speed * self.settings.latency + speed**2 / (2 * situation.limits.acceleration)
        room = stopping + situation.limits.airframe_radius
        room -= arm(situation.limits, situation.load) * math.sqrt(0.5)  # lasers sit that far out
        lasers = reading.lasers
        if state in SIDEWAYS:
            right = state in (State.Q3, State.Q10)
            right = right or (state is State.Q5 and self._memory.rightwards)
            if lasers[S4 if right else S2] < room:
                return f"something stands to the {'right' if right else 'left'}"
            aside = situation.active.at(situation.now).position_site - flown.began
            if abs(float(flown.facing[0] * aside[1] - flown.facing[1] * aside[0])) > WIDEST:
                return f"no end of the obstacle within {WIDEST:.0f} m"
        if state in FORWARD:
            ahead = self._view.obstacle(situation, situation.limits.airframe_radius)
            here = situation.vehicle.position_site
            near = math.inf if ahead is None else float(np.linalg.norm((ahead - here)[:2]))
            if min(lasers[S1], lasers[S3]) < room or near < stopping + room:
                return "something else stands ahead"
            along = situation.active.at(situation.now).position_site - flown.began
            if float(along[:2] @ flown.facing) > LONGEST:
                return f"no end of the obstacle within {LONGEST:.0f} m"
        if state in (State.Q0, State.Q1) and reading.ahead < stopping:
            return "it is too near to turn aside"
        return ""

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

    def _wait(self, situation: Situation, reading: Reading) -> Verdict:
        """At rest: go on when the way ahead has been free for a while."""
        rest = situation.now >= situation.active.end
        lasers = min(reading.lasers[S1], reading.lasers[S3])
        there = situation.reference.at(self._abreast(situation)).position_site
        aside = float(np.linalg.norm(situation.active.at(situation.now).position_site - there))
        if aside > ON_LINE:
            return Keep(f"stopped {aside:.1f} m beside the route: nothing sees the way back", 0.0)
        if rest and situation.now - self._seen > CLEAR and math.isinf(lasers):
            return self._return(situation, "the way is free again")
        return Keep("stopped: the way is not free", 0.0)
