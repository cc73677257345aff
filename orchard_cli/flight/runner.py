"""The one loop that acts.

Each cycle: look and think (lookout.py), gather what is seen (observer.py), decide (phases.py,
safety.py: pure), then stream, ask, write and show. It does not know whether the clock, the vehicle
and the camera are simulated.
"""

from __future__ import annotations

from orchard_cli.model.mission import Mission
from orchard_cli.model.records import Severity
from orchard_cli.model.vehicle import Command, VehicleState

from .anchored import Anchored
from .gauge import Gauge
from .gear import Ending, Gear
from .helm import Helm
from .lookout import Lookout
from .observer import Observer, Told
from .passage import Passage
from .phases import begin, step
from .safety import Phase, Request, Seen, Tolerances
from .spray import SprayLines, spray
from .stage import Decision, Stage

RATE = 50.0  # Hz of the control loop and of the setpoint stream
REQUEST_LIFE = 1.0  # s for which the operator's request is told again until it is acted upon
LOST = 5.0  # s of silence at the end: what became of the vehicle is not known


class Flight:
    """One mission, flown once."""

    def __init__(self, mission: Mission, gear: Gear, tolerances: Tolerances | None = None) -> None:
        self._mission = mission
        self._gear = gear
        self._vehicle = Anchored(gear.vehicle)
        self._tolerances = tolerances or Tolerances()
        self._helm = Helm(mission, gear.errands, gear.yaw_rule)
        self._lookout = Lookout(gear, self._vehicle, self._helm, mission.limits.airframe_radius)
        self._observer = Observer(
            mission, self._vehicle, self._helm, self._lookout, self._tolerances
        )
        self._lines = SprayLines.of(mission)
        self._gauge = Gauge(gear.load, gear.vehicle.pump)
        self._passage = Passage(mission.waypoints_site)
        self._refused: str | None = None
        self._asked: tuple[Request, float] | None = None
        self._streaming = False

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
        self._lookout.look(state, now)
        self._lookout.think(state, self._gauge.load, self._observer.widening, now)
        self._hear(now)
        seen = self._observer.gather(stage, state, self._told(), now)
        decision = step(stage, seen, now, self._tolerances)
        after = decision.stage
        if after.phase is not stage.phase or after.since != stage.since:
            self._asked = None
            self._refused = None
            severity = Severity.INFO if after.as_planned else Severity.WARNING
            change = f"{stage.phase.value} -> {after.phase.value}"
            self._gear.reporter.say(now, severity, f"{change}: {after.why}")
        self._pass(stage.phase, seen, now)
        self._act(decision, state, now)
        self._tell(decision, seen, now)
        return after

    def _told(self) -> Told:
        request = None if self._asked is None else self._asked[0]
        lost = bool(self._gear.recorder.losses)
        return Told(request, self._refused, self._gauge.empty, lost)

    def _steady(self, state: VehicleState | None, now: float) -> None:
        """Tell of jumps of the estimate; the nose is now where it seems to be."""
        for jump in self._vehicle.jumps():
            self._observer.jumped(now)
            self._gear.reporter.say(now, Severity.WARNING, str(jump))
            if jump.turned and state is not None:
                self._helm.guidance.face(state.yaw_site)

    def _pass(self, phase: Phase, seen: Seen, now: float) -> None:
        """Tell of waypoints that are left out."""
        if seen.vehicle is None or phase not in (Phase.ROUTE, Phase.AVOIDANCE):
            return
        missed = self._passage.missed(seen.vehicle.position_site)
        for number in missed + (self._passage.rest() if seen.route_done else ()):
            text = f"waypoint {number} was not come to: it is left out"
            self._gear.reporter.say(now, Severity.WARNING, text)

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
        self._observer.sent(setpoint)
        if decision.command is not None:
            vehicle.command(decision.command, self._mission.takeoff_height)

    def _tell(self, decision: Decision, seen: Seen, now: float) -> None:
        state, active = seen.vehicle, self._helm.guidance.active
        phase, gauge = decision.stage.phase, self._gauge
        spraying = None if state is None else spray(self._lines, phase, state, gauge.empty)
        gauge.run(spraying is not None and spraying.on, now)
        span = (0.0 if active is None else now - active.start, self._helm.guidance.remaining(now))
        self._gear.reporter.cycle(decision, seen, spraying, gauge, span, now)
        for truth in self._gear.truth.take() if self._gear.truth is not None else ():
            self._gear.recorder.write(truth)
