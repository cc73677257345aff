"""The one loop that acts.

Each cycle: gather what is seen, decide (phases.py, safety.py: pure), then stream, ask, write and
show. It does not know whether the clock, the vehicle and the camera are simulated.
"""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.model.mission import Mission
from orchard_cli.model.records import NewTrajectory, Severity
from orchard_cli.model.sensors import Sensed
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import Command, FlightMode, Landed, VehicleState
from orchard_cli.motion.situation import Avoid, Keep

from .anchored import Anchored
from .boundary import NO_EDGE, Margins, area_of, margins
from .gauge import Gauge
from .gear import Ending, Gear
from .helm import Helm
from .inbox import Inbox
from .onboard import OnboardJob, OnboardResult
from .phases import begin, step
from .preflight import not_ready
from .safety import Phase, Request, Seen, Tolerances
from .skipped import skipped
from .spray import spray
from .stage import Decision, Stage

RATE = 50.0  # Hz of the control loop and of the setpoint stream
COMMIT = 0.3  # s: an avoidance begins at least this much after it was asked for
REQUEST_LIFE = 1.0  # s for which the operator's request is told again until it is acted upon
CLIMBED = 1.2  # m below its height at which PX4 calls a take-off done (0.8 m) and a margin
AT_ROUTE = 1.0  # m, and
ALONG_ROUTE = 0.25  # rad, between the vehicle and where it should stand before a route begins
LOST = 5.0  # s of silence at the end: what became of the vehicle is not known


class Flight:
    """One mission, flown once."""

    def __init__(self, mission: Mission, gear: Gear, tolerances: Tolerances | None = None) -> None:
        self._mission = mission
        self._begin = float(mission.trajectory.control_points_site[0, 2])  # m, the route's height
        self._gear = gear
        self._vehicle = Anchored(gear.vehicle)
        self._tolerances = tolerances or Tolerances()
        self._area = area_of(mission)
        self._helm = Helm(mission, gear.errands)
        self._inbox = Inbox()
        self._sensed = Sensed()
        self._gauge = Gauge(gear.load, gear.vehicle.pump)
        self._planned = -math.inf
        self._refused: str | None = None
        self._asked: tuple[Request, float] | None = None
        self._upright = math.inf  # s, when the vehicle was last seen flying as it should
        self._streaming = False
        self._jumped = -math.inf  # s, when the position estimate last jumped

    def run(self) -> Ending:
        """Fly until the flight has ended; always leaves the stream stopped and the guard off."""
        gear = self._gear
        began = gear.clock.now()
        stage, tick, flown = begin(began), 0, False
        try:
            while stage.phase is not Phase.ENDED:
                tick = max(tick + 1, int((gear.clock.now() - began) * RATE))
                self._sleep(began + tick / RATE)
                stage = self._cycle(stage, gear.clock.now())
                flown = flown or stage.phase is Phase.TAKEOFF
        except Exception:
            self._vehicle.command(Command.HOLD)  # nobody will decide any more
            raise
        finally:
            self._gauge.run(False, gear.clock.now())
            self._vehicle.stop_sending()
            gear.guard.disarm()
        state = self._vehicle.state()
        lost = state is not None and gear.clock.now() - state.heard > LOST
        refused = not flown and stage.cause is None
        return Ending(stage.as_planned, stage.why, lost or refused)

    def _sleep(self, until: float) -> None:
        """Wait for a time of the flight clock. Awake meanwhile: a clock may stand, this may not."""
        while True:
            self._gear.clock.sleep_until(until)
            if self._streaming:
                self._gear.guard.feed()
            if self._gear.clock.now() >= until - 1e-9:
                return

    def _cycle(self, stage: Stage, now: float) -> Stage:
        state = self._vehicle.state()
        self._steady(state, now)
        self._look(now)
        self._think(state, now)
        seen = self._gather(stage, state, now)
        decision = step(stage, seen, now, self._tolerances)
        after = decision.stage
        if after.phase is not stage.phase or after.since != stage.since:
            self._asked = None
            self._refused = None
            severity = Severity.INFO if after.as_planned else Severity.WARNING
            change = f"{stage.phase.value} -> {after.phase.value}"
            self._gear.reporter.say(now, severity, f"{change}: {after.why}")
        self._act(decision, state, now)
        self._tell(decision, seen, now)
        return after

    def _steady(self, state: VehicleState | None, now: float) -> None:
        """Tell of jumps of the estimate; the nose is now where it seems to be."""
        for jump in self._vehicle.jumps():
            self._jumped = now
            self._gear.reporter.say(now, Severity.WARNING, str(jump))
            if jump.turned and state is not None:
                self._helm.guidance.face(state.yaw_site)

    def _look(self, now: float) -> None:
        """Take the newest frame and the newest scans, and log what is new."""
        frame = self._gear.camera.latest()
        if frame is not None:
            self._gear.recorder.write(frame)
            self._inbox.put(frame, now)
        if self._gear.sensors is not None:
            before, self._sensed = self._sensed.scans(), self._gear.sensors.newest()
            known = {(type(scan), scan.time) for scan in before}
            for scan in self._sensed.scans():
                if (type(scan), scan.time) not in known:
                    self._gear.recorder.write(scan)

    def _think(self, state: VehicleState | None, now: float) -> None:
        """Collect the finished onboard cycle and start the next one."""
        worker, guidance = self._gear.worker, self._helm.guidance
        result = worker.take(now)
        if isinstance(result, Exception):
            self._gear.reporter.say(now, Severity.ERROR, f"onboard cycle failed: {result!r}")
        elif result is not None:
            self._gear.reporter.onboard(result)
            self._take(result, now)
        frame = self._inbox.take(state.time) if state is not None and worker.idle() else None
        if frame is None or state is None:
            return
        poses = self._vehicle.poses(frame.time - 0.2)
        job = OnboardJob(
            now, now + COMMIT, frame, poses, state, guidance.active, guidance.reference,
            self._sensed, self._gauge.load,
        )  # fmt: skip
        worker.give(job, now)

    def _take(self, result: OnboardResult, now: float) -> None:
        """Fly a new trajectory, unless it was made for one that is no longer flown.

        Only an answer in time, from a frame that was mapped, shows that somebody looks ahead; a
        way round that came too late shows that nobody does.
        """
        before, verdict = self._helm.guidance.active, result.verdict
        in_time = result.mapped and now <= result.job.commit
        if in_time:
            self._planned = now
        if result.job.active is not before or isinstance(verdict, Keep):
            return
        if not in_time or not self._helm.take(verdict, result.job.commit, now):
            self._planned = -math.inf
            self._gear.reporter.say(now, Severity.WARNING, f"too late to be flown: {verdict.why}")
        after = self._helm.guidance.active
        if after is not None and after is not before:
            self._tell_skipped(before, after, now)
            guide = verdict.guide_site if isinstance(verdict, Avoid) else np.empty((0, 3))
            self._gear.recorder.write(NewTrajectory(now, after, guide, verdict.why))

    def _tell_skipped(self, before: Trajectory | None, after: Trajectory, now: float) -> None:
        gone = (
            ()
            if before is None or self._helm.guidance.blocked
            else skipped(self._mission, before, after, now)
        )
        for number in gone:
            text = f"the way round does not come to waypoint {number}: it is left out"
            self._gear.reporter.say(now, Severity.WARNING, text)

    def _gather(self, stage: Stage, state: VehicleState | None, now: float) -> Seen:
        guidance, tolerances = self._helm.guidance, self._tolerances
        self._hear(now)
        frame_age, planner_age = now - self._inbox.newest, now - self._planned
        checking = stage.phase is Phase.PREFLIGHT
        behind = self._behind(state, now)
        reserve = self._mission.limits.reserve
        return Seen(
            vehicle=state,
            silence=math.inf if state is None else now - min(state.heard, state.time),
            frame_age=frame_age,
            planner_age=planner_age,
            off_track=float(np.linalg.norm(behind)),
            falling=self._falling(state, float(behind[2]), now),
            blocked=guidance.blocked,
            avoiding=guidance.avoiding(now),
            routed=guidance.reference is not None,
            joining=guidance.pending,
            climbed=self._climbed(state),
            still=guidance.still(now),
            joined=self._joined(state, behind, now),
            route_done=guidance.arrived(now),
            return_share=self._return_share(now),
            critical_share=reserve / 2,
            not_ready=not_ready(self._mission, state, frame_age, planner_age, tolerances)
            if checking
            else (),
            since_jump=now - self._jumped,
            margins=self._margins(state),
            strayed=float(np.linalg.norm(self._vehicle.shift_site)),
            request=None if self._asked is None else self._asked[0],
            refused=self._refused,
        )

    def _margins(self, state: VehicleState | None) -> Margins:
        """From the edges of the fence and the keep-outs."""
        if state is None:
            return NO_EDGE
        shift, deceleration = self._vehicle.shift_site, self._mission.limits.acceleration
        return margins(self._area, state, shift, deceleration)

    def _hear(self, now: float) -> None:
        """Answers of the autopilot, and requests of the operator."""
        for answer in self._vehicle.answers():
            self._refused = None if answer.accepted else answer.said
            severity = Severity.INFO if answer.accepted else Severity.WARNING
            self._gear.reporter.say(answer.time, severity, f"{answer.command.value}: {answer.said}")
        request = self._gear.operator.request()
        if request is not None:
            self._asked = (request, now)
        elif self._asked is not None and now - self._asked[1] > REQUEST_LIFE:
            self._asked = None

    def _behind(self, state: VehicleState | None, now: float) -> Vector:
        """(3,) m from the vehicle to where it should be; zero when nothing is streamed."""
        if state is None or not self._streaming or state.mode is not FlightMode.OFFBOARD:
            return np.zeros(3)
        behind: Vector = self._helm.guidance.position(now) - state.position_site
        return behind

    def _falling(self, state: VehicleState | None, under: float, now: float) -> float:
        """Seconds for which the vehicle has been far under its setpoint, or on the ground."""
        down = state is not None and state.landed is Landed.ON_GROUND
        if not down and under <= self._tolerances.sunk:
            self._upright = now
        return now - min(self._upright, now)

    def _climbed(self, state: VehicleState | None) -> bool:
        return state is not None and float(state.position_site[2]) > self._begin - CLIMBED

    def _joined(self, state: VehicleState | None, behind: Vector, now: float) -> bool:
        """Whether vehicle and setpoint both stand at the route's next point, looking along it."""
        guidance = self._helm.guidance
        if state is None or state.mode is not FlightMode.OFFBOARD or not guidance.joined(now):
            return False
        near = float(np.linalg.norm(behind)) < AT_ROUTE
        return near and guidance.yaw_error(state.yaw_site) < ALONG_ROUTE

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
        vehicle, guard = self._vehicle, self._gear.guard
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
        phase, gauge = decision.stage.phase, self._gauge
        spraying = None if state is None else spray(self._mission, phase, state, gauge.empty)
        gauge.run(spraying is not None and spraying.on, now)
        span = (0.0 if active is None else now - active.start, self._helm.guidance.remaining(now))
        self._gear.reporter.cycle(decision, seen, spraying, gauge, span, now)
        for truth in self._gear.truth.take() if self._gear.truth is not None else ():
            self._gear.recorder.write(truth)
