"""When to replan, when to stop: the state machine of EGO-Planner, asked once a frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orchard_cli.model.trajectory import Trajectory
from orchard_cli.motion.braking import brake
from orchard_cli.motion.situation import Avoid, Keep, Situation, Stop, Verdict
from orchard_cli.motion.stopwatch import Stopwatch

from .obstacles import Obstacles, look
from .replan import Curve, NoCurve, Task, from_previous, from_rest, load_kernels, task_pace
from .route import Target, aim, goals
from .settings import EgoSettings


class Ego:
    """Flies from one local curve to the next; nothing that the curve does not touch costs it.

    A goal is where the reference comes to rest: the next one is aimed at when one is reached.
    Remembers the curve being flown, the one offered last, and how far along the reference it is.
    """

    name = "ego"
    needs: frozenset[str] = frozenset()

    def __init__(self, settings: EgoSettings | None = None) -> None:
        self.settings = settings or EgoSettings()
        self._random = np.random.default_rng(self.settings.seed)
        self._curve: Curve | None = None
        self._offered: Curve | None = None
        self._stop: Trajectory | None = None  # offered last, to be at rest
        self._progress = -np.inf  # s on the reference's clock
        self._given: Trajectory | None = None  # the reference that `_goals` is of
        self._goals = np.empty(0)  # s on its clock, those not reached yet
        self._failures = 0
        load_kernels(self.settings)

    @classmethod
    def published(cls) -> Ego:
        """With the authors' horizon, inflation and acceleration."""
        return cls(EgoSettings.published())

    def plan(self, situation: Situation) -> Verdict:
        """Keep the curve while it is free and new, replan it, or stop before what it hits."""
        watch = Stopwatch()
        with watch.stage("target"):
            curve = self._flown(situation)
            arrived = self._arrive(situation, curve)
            target = self._aim(situation, curve)
        with watch.stage("window"):
            obstacles = self._look(situation, curve, target)
        with watch.stage("check"):
            hit = self._hit(situation, curve, obstacles)
        stopped = situation.active is self._stop
        if hit is None and not stopped and not arrived and not self._due(situation, curve):
            return Keep(stages_ms=watch.stages_ms)
        with watch.stage("replan"):
            found = self._replan(situation, curve, target, obstacles, stopped)
        return replace(self._answer(situation, found, hit), stages_ms=watch.stages_ms)

    def _flown(self, situation: Situation) -> Curve:
        """The curve that is being flown; a trajectory of someone else's begins one here."""
        active = situation.active
        if self._offered is not None and active is self._offered.trajectory:
            self._curve = self._offered
        if self._curve is None or active is not self._curve.trajectory:
            now = situation.now
            if active is situation.reference:
                self._progress = min(max(now, active.start), active.end)
            ahead = self.settings.horizon / situation.limits.speed
            reached = max(self._progress, situation.reference.start)
            self._curve = Curve(active, now, now, now + ahead, reached)
        return self._curve

    def _arrive(self, situation: Situation, curve: Curve) -> bool:
        """Whether a goal on the way is reached with this frame; the next one is then aimed at."""
        reference = situation.reference
        if self._given is not reference:
            self._given, self._goals = reference, goals(reference)
        passed = self._goals[:-1] <= curve.reached
        if situation.commit < curve.end or not passed.any():
            return False
        self._goals = self._goals[np.count_nonzero(passed) :]
        return True

    def _aim(self, situation: Situation, curve: Curve) -> Target:
        reference = situation.reference
        here = situation.active.at(situation.commit).position_site
        progress = min(max(self._progress, reference.start), reference.end)
        target = aim(
            reference, here, progress, max(curve.reached, progress), self.settings.horizon,
            float(self._goals[0]),
        )  # fmt: skip
        self._progress = target.progress
        return target

    def _look(self, situation: Situation, curve: Curve, target: Target) -> Obstacles:
        s, active = self.settings, situation.active
        ends = (situation.commit, (situation.commit + curve.end) / 2, curve.end)
        places = [active.at(t).position_site for t in ends]
        inflation = situation.limits.airframe_radius if s.inflation is None else s.inflation
        corners = np.array([*places, target.state.position_site])
        return look(situation.grid, corners, s.around, s.above, inflation)

    def _hit(self, situation: Situation, curve: Curve, obstacles: Obstacles) -> float | None:
        """When the checked share of the curve first hits; at least all that braking needs is."""
        until = curve.begin + self.settings.checked * (curve.end - curve.begin)
        until = max(until, situation.commit + self._emergency(situation))
        return obstacles.first_hit(situation.active, situation.commit, until)

    def _emergency(self, situation: Situation) -> float:
        """Seconds before a conflict under which the vehicle must stop: never less than it needs."""
        speed = float(np.linalg.norm(situation.active.at(situation.commit).velocity_site))
        braking = speed / situation.limits.acceleration + situation.active.interval
        return max(self.settings.emergency, braking)

    def _due(self, situation: Situation, curve: Curve) -> bool:
        """Whether the curve has been flown far enough to replace it."""
        active, reference, s = situation.active, situation.reference, self.settings
        here = active.at(situation.now).position_site
        goal = reference.at(float(self._goals[0])).position_site
        if np.linalg.norm(goal - here) <= s.no_replan_within:
            return False
        began = active.at(curve.asked).position_site
        return bool(np.linalg.norm(here - began) > s.replan_after)

    def _replan(
        self,
        situation: Situation,
        curve: Curve,
        target: Target,
        obstacles: Obstacles,
        stopped: bool,
    ) -> Curve | NoCurve:
        """From the curve's rest, with a quintic, with a random one: the first that works.

        Standing, there is time: a quintic and a random one take turns.
        """
        s = self.settings
        task = Task(
            situation.now, situation.commit, situation.active, situation.reference,
            target, obstacles, task_pace(situation.limits, s),
        )  # fmt: skip
        found: Curve | NoCurve = NoCurve("no way was tried yet")
        if not stopped and curve is self._offered:
            found = from_previous(task, curve.end, s)
        if isinstance(found, NoCurve) and not (stopped and self._failures % 2):
            found = from_rest(task, s)
        if isinstance(found, NoCurve) and not (stopped and self._failures % 2 == 0):
            found = from_rest(task, s, self._failures, self._random)
        self._failures = self._failures + 1 if isinstance(found, NoCurve) else 0
        return found

    def _answer(self, situation: Situation, found: Curve | NoCurve, hit: float | None) -> Verdict:
        blocked_at = None if hit is None else _travel(situation.active, situation.now, hit)
        if isinstance(found, Curve):
            self._offered, self._stop = found, None
            way = "pushed off what is in the way" if found.touched else "free"
            return Avoid(
                found.trajectory, found.begin, found.rejoin,
                f"next curve, {way}" if blocked_at is None else f"blocked in {blocked_at:.1f} m",
                blocked_at or 0.0,
            )  # fmt: skip
        if hit is None or blocked_at is None:
            return Keep(f"no new curve: {found.why}")
        if hit - situation.commit > self._emergency(situation) or situation.active is self._stop:
            return Keep(f"blocked in {blocked_at:.1f} m: {found.why}", blocked_at)
        self._stop = brake(situation.active, situation.commit, situation.limits.acceleration)
        return Stop(self._stop, found.why, blocked_at)


def _travel(trajectory: Trajectory, begin: float, end: float) -> float:
    """Metres from one time to another."""
    places = trajectory.sample(np.linspace(begin, max(end, begin), 50))[0]
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
