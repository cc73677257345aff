"""The one loop that acts.

Each cycle: gather what is seen, decide (phases.py, safety.py: pure), then stream, ask, write and
show. It does not know whether the clock, the vehicle and the camera are simulated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.mission import Mission
from orchard_cli.model.records import NewTrajectory, Severity
from orchard_cli.model.vehicle import FlightMode, VehicleState
from orchard_cli.motion.situation import Avoid

from .helm import Helm
from .onboard import OnboardJob, OnboardResult
from .phases import Decision, Stage, begin, step
from .ports import Camera, Clock, Guard, Operator, Recorder, Truth, Vehicle
from .preflight import not_ready
from .reporter import Reporter
from .safety import Phase, Seen, Tolerances
from .spray import spray
from .worker import Worker

RATE = 50.0  # Hz of the control loop and of the setpoint stream
COMMIT = 0.3  # s: an avoidance begins at least this much after it was asked for


@dataclass(frozen=True, slots=True)
class Gear:
    """Everything plugged into the loop."""

    vehicle: Vehicle
    camera: Camera
    worker: Worker[OnboardJob, OnboardResult]
    clock: Clock
    recorder: Recorder
    reporter: Reporter
    operator: Operator
    guard: Guard
    truth: Truth | None = None


@dataclass(frozen=True, slots=True)
class Ending:
    """How the flight ended."""

    as_planned: bool
    why: str


class Flight:
    """One mission, flown once."""

    def __init__(self, mission: Mission, gear: Gear, tolerances: Tolerances | None = None) -> None:
        self._mission = mission
        self._gear = gear
        self._tolerances = tolerances or Tolerances()
        self._helm = Helm(mission)
        self._frame: DepthFrame | None = None  # newest that was not worked on yet
        self._frame_time = -math.inf
        self._planned = -math.inf
        self._refused: str | None = None
        self._streaming = False

    def run(self) -> Ending:
        """Fly until the flight has ended; always leaves the stream stopped and the guard off."""
        gear = self._gear
        began = gear.clock.now()
        stage, tick = begin(began), 0
        try:
            while stage.phase is not Phase.ENDED:
                tick = max(tick + 1, int((gear.clock.now() - began) * RATE))
                gear.clock.sleep_until(began + tick / RATE)
                stage = self._cycle(stage, gear.clock.now())
        finally:
            gear.vehicle.stop_sending()
            gear.guard.disarm()
        return Ending(stage.as_planned, stage.why)

    def _cycle(self, stage: Stage, now: float) -> Stage:
        state = self._gear.vehicle.state()
        self._look(now)
        self._think(state, now)
        seen = self._gather(stage, state, now)
        decision = step(stage, seen, now, self._tolerances)
        if decision.stage.phase is not stage.phase:
            self._refused = None
            severity = Severity.INFO if decision.stage.as_planned else Severity.WARNING
            change = f"{stage.phase.value} -> {decision.stage.phase.value}"
            self._gear.reporter.say(now, severity, f"{change}: {decision.stage.why}")
        self._act(decision, state, now)
        self._tell(decision, seen, now)
        return decision.stage

    def _look(self, now: float) -> None:
        """Take the newest frame; a blank one is as good as none."""
        frame = self._gear.camera.latest()
        if frame is None:
            return
        self._gear.recorder.write(frame)
        if frame.depth_mm.any():
            self._frame, self._frame_time = frame, min(frame.time, now)

    def _think(self, state: VehicleState | None, now: float) -> None:
        """Collect the finished onboard cycle and start the next one."""
        worker, guidance = self._gear.worker, self._helm.guidance
        result = worker.take(now)
        if isinstance(result, Exception):
            self._gear.reporter.say(now, Severity.ERROR, f"onboard cycle failed: {result!r}")
        elif result is not None:
            self._planned = now
            self._gear.reporter.onboard(result)
            self._take(result, now)
        if self._frame is None or state is None or not worker.idle():
            return
        frame, self._frame = self._frame, None
        poses = self._gear.vehicle.poses(frame.time - 0.2)
        job = OnboardJob(
            now, now + COMMIT, frame, poses, state, guidance.active, guidance.reference
        )
        worker.give(job, now)

    def _take(self, result: OnboardResult, now: float) -> None:
        """Fly a new trajectory, unless it was made for one that is no longer flown."""
        before = self._helm.guidance.active
        if result.job.active is not before:
            return
        if not self._helm.take(result.verdict, result.job.commit, now):
            self._gear.reporter.say(now, Severity.WARNING, "an avoidance came too late to be flown")
        after = self._helm.guidance.active
        if after is not None and after is not before:
            verdict = result.verdict
            guide = verdict.guide_site if isinstance(verdict, Avoid) else np.empty((0, 3))
            self._gear.recorder.write(NewTrajectory(now, after, guide, verdict.why))

    def _gather(self, stage: Stage, state: VehicleState | None, now: float) -> Seen:
        guidance = self._helm.guidance
        for answer in self._gear.vehicle.answers():
            self._refused = None if answer.accepted else answer.said
            severity = Severity.INFO if answer.accepted else Severity.WARNING
            self._gear.reporter.say(answer.time, severity, f"{answer.command.value}: {answer.said}")
        frame_age, planner_age = now - self._frame_time, now - self._planned
        checking = stage.phase is Phase.PREFLIGHT
        behind = self._behind(state, now)
        reserve = self._mission.limits.reserve
        return Seen(
            vehicle=state,
            silence=math.inf if state is None else now - state.heard,
            frame_age=frame_age,
            planner_age=planner_age,
            off_track=float(np.linalg.norm(behind)),
            sunk=max(float(behind[2]), 0.0),
            blocked=guidance.blocked,
            avoiding=guidance.avoiding(now),
            still=guidance.still(now),
            joined=state is not None and state.mode is FlightMode.OFFBOARD and guidance.joined(now),
            route_done=guidance.arrived(now),
            return_share=self._return_share(now),
            critical_share=reserve / 2,
            not_ready=not_ready(self._mission, state, frame_age, planner_age, self._tolerances)
            if checking
            else (),
            request=self._gear.operator.request(),
            refused=self._refused,
        )

    def _behind(self, state: VehicleState | None, now: float) -> Vector:
        """(3,) m from the vehicle to where it should be; zero when nothing is streamed."""
        if state is None or not self._streaming or state.mode is not FlightMode.OFFBOARD:
            return np.zeros(3)
        behind: Vector = self._helm.guidance.position(now) - state.position_site
        return behind

    def _return_share(self, now: float) -> float:
        """Share of the battery below which to turn back, with half of the reserve.

        Nearer to the end of the route than to its beginning, flying on is the shorter way down:
        then there is none.
        """
        limits, guidance = self._mission.limits, self._helm.guidance
        back = self._helm.trail.length / limits.speed
        if guidance.reference is not None and guidance.remaining(now) < back:
            return 0.0
        return back / limits.endurance + limits.reserve / 2

    def _act(self, decision: Decision, state: VehicleState | None, now: float) -> None:
        """Stream, ask, and keep the guard fed for as long as something is streamed."""
        vehicle, guard = self._gear.vehicle, self._gear.guard
        setpoint = None if state is None else self._helm.steer(decision, state, now)
        if setpoint is not None:
            vehicle.send(setpoint)
            guard.feed()
            self._gear.recorder.write(setpoint)
        elif self._streaming:
            vehicle.stop_sending()
            guard.disarm()
        self._streaming = setpoint is not None
        if decision.command is not None:
            vehicle.command(decision.command, self._mission.takeoff_height)

    def _tell(self, decision: Decision, seen: Seen, now: float) -> None:
        state, active = seen.vehicle, self._helm.guidance.active
        spraying = spray(self._mission, decision.stage.phase, state) if state is not None else None
        span = (0.0 if active is None else now - active.start, self._helm.guidance.remaining(now))
        self._gear.reporter.cycle(decision, seen, spraying, span, now)
        for truth in self._gear.truth.take() if self._gear.truth is not None else ():
            self._gear.recorder.write(truth)
