"""The sockets. Equipment rooms fit these by shape; commands/wiring.py plugs them in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from orchard_cli.model.depth import DepthCamera, DepthFrame
from orchard_cli.model.records import Record, TruthRecord
from orchard_cli.model.sensors import Sensed
from orchard_cli.model.vehicle import Answer, Command, Pose, Setpoint, VehicleState
from orchard_cli.motion.situation import Situation, Verdict

from .safety import Request
from .status import Status


class Clock(Protocol):
    """The flight clock: monotonic on a real vehicle, simulated when simulated."""

    def now(self) -> float:
        """Seconds."""
        ...

    def sleep_until(self, time: float) -> None:
        """Return at or just after `time`, at once when it has passed.

        Where that takes more than about 0.1 s of real time it returns earlier, to be called again.
        """
        ...


class Vehicle(Protocol):
    """An autopilot. No call blocks; what happened is seen in `state` and `answers`."""

    def state(self) -> VehicleState | None:
        """Newest telemetry; None until position, attitude and mode have been heard."""
        ...

    def poses(self, since: float) -> tuple[Pose, ...]:
        """Poses measured after `since`, oldest first, at most the last 2 s."""
        ...

    def send(self, setpoint: Setpoint) -> None:
        """Stream one offboard setpoint."""
        ...

    def stop_sending(self) -> None:
        """End the setpoint stream, so that the autopilot's own offboard-loss failsafe rules."""
        ...

    def command(self, command: Command, height: float = float("nan")) -> None:
        """Ask for something, in order, without waiting. `height` (m above home) is for TAKEOFF."""
        ...

    def pump(self, on: bool) -> None:
        """Run the spray pump, or stop it; asked on changes, and only of a vehicle with a tank."""
        ...

    def answers(self) -> tuple[Answer, ...]:
        """Answers that came since the last call, oldest first."""
        ...

    def close(self) -> None:
        """Stop the stream and let go of the link."""
        ...


class Camera(Protocol):
    """A depth camera."""

    model: DepthCamera

    def latest(self) -> DepthFrame | None:
        """The newest frame that has not been handed out yet, or None. Older ones are dropped."""
        ...

    def close(self) -> None:
        """Let go of the device."""
        ...


class Sensors(Protocol):
    """What is fitted besides the depth camera."""

    def newest(self) -> Sensed:
        """The newest scan of each sensor, with the flight clock's time on it."""
        ...


class Truth(Protocol):
    """A simulator's knowledge of what really happens; absent on a real vehicle."""

    def take(self) -> tuple[TruthRecord, ...]:
        """What happened since the last call."""
        ...


class Avoidance(Protocol):
    """An avoidance system. Pure apart from its own memory; called once per depth frame."""

    name: str
    needs: frozenset[str]  # sensors besides depth, of model/sensors.py SENSORS

    def plan(self, situation: Situation) -> Verdict:
        """Keep the active trajectory, replace it, or stop."""
        ...


class Recorder(Protocol):
    """The flight log. `write` never blocks the loop and never raises; losses are counted."""

    def write(self, record: Record) -> None:
        """Queue one record."""
        ...

    @property
    def losses(self) -> Mapping[str, int]:
        """How many records were lost so far, by reason; empty when none."""
        ...

    def close(self) -> None:
        """Write out everything and finish the file."""
        ...


class Display(Protocol):
    """Where a human watches."""

    def show(self, status: Status) -> None:
        """Take the newest status; drawing happens elsewhere."""
        ...


class Operator(Protocol):
    """The human at the keyboard."""

    def request(self) -> Request | None:
        """What was asked for since the last call."""
        ...


class Guard(Protocol):
    """Ends the process from outside when it is not fed (vehicle/deadman.py)."""

    def feed(self) -> None:
        """The loop is alive."""
        ...

    def disarm(self) -> None:
        """Nothing is streamed any more."""
        ...
