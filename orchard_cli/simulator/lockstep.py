"""The simulator without MAVLink and without real time: it advances when its clock is slept on."""

from __future__ import annotations

import math
from collections import deque

from orchard_cli.model.arrays import Vector
from orchard_cli.model.depth import DepthCamera, DepthFrame
from orchard_cli.model.records import TruthRecord
from orchard_cli.model.sensors import Sensed
from orchard_cli.model.site import SiteOrigin
from orchard_cli.model.vehicle import Answer, Command, Pose, Setpoint, VehicleState, poses_after
from orchard_cli.model.world import World

from .autopilot import Autopilot, Mode, Result, Wanted
from .faults import SimulatedFault
from .run import Run
from .settings import SimulatorSettings

POSE_EVERY = 2  # ticks: the link's 50 Hz
HEARTBEAT_EVERY = 100  # ticks: mode and arming are heard once a second, as over MAVLink
POSE_HISTORY = 2.0  # s

_MODES = {
    Command.OFFBOARD: Mode.OFFBOARD,
    Command.HOLD: Mode.HOLD,
    Command.RETURN: Mode.RETURN,
    Command.LAND: Mode.LAND,
}


class LockstepSimulator:
    """Clock, vehicle, camera and truth of one run; all fit the sockets in flight/ports.py.

    The same arguments and the same calls give the same bits. `origin` is not needed here, where
    nothing is told in degrees; it is taken so that both simulators are made alike.
    """

    def __init__(
        self,
        world: World,
        origin: SiteOrigin,
        start_site: tuple[float, float],
        start_yaw_site: float,
        settings: SimulatorSettings | None = None,
        ground_site: float = 0.0,
    ) -> None:
        self.origin = origin
        self._run = Run(world, start_site, start_yaw_site, settings or SimulatorSettings())
        self.vehicle = LockstepVehicle(self._run.autopilot, ground_site)
        self.camera = LockstepCamera(self._run.camera) if self._run.camera else None
        self.truth = LockstepTruth()
        self.sensors = LockstepSensors()
        self.clock = LockstepClock(self)

    @property
    def time(self) -> float:
        """Simulated seconds since boot."""
        return self._run.time

    def inject(self, fault: SimulatedFault) -> None:
        """Make something go wrong from the next tick on."""
        self._run.inject(fault)

    def step(self) -> None:
        """Advance by one tick."""
        self.vehicle.before()
        due = self._run.step()
        self.vehicle.after()
        if due.truth is not None:
            self.truth.records.append(due.truth)
        if due.frame is not None and self.camera is not None:
            self.camera.frame = due.frame
        for scan in due.scans:
            self.sensors.sensed = self.sensors.sensed.after(scan)


class LockstepClock:
    """Time stands still between calls and advances by whole ticks."""

    def __init__(self, simulator: LockstepSimulator) -> None:
        self._simulator = simulator

    def now(self) -> float:
        """Simulated seconds since boot."""
        return self._simulator.time

    def sleep_until(self, moment: float) -> None:
        """Simulate up to `moment` or just after."""
        while self._simulator.time < moment - 1e-9:
            self._simulator.step()


class LockstepVehicle:
    """The autopilot behind the vehicle socket, with what MAVSDK does in between.

    A setpoint is sent again and again until `stop_sending`; mode, arming and readiness are heard
    once a second; a mode change is accepted before it is decided; height is counted from the
    ground that the disarmed vehicle stands on, which is at `ground_site` m in the site frame.
    """

    def __init__(self, autopilot: Autopilot, ground_site: float) -> None:
        self._autopilot = autopilot
        self._ground_site = ground_site
        self._streaming: Setpoint | None = None
        self._answers: list[Answer] = []
        self._poses: deque[Pose] = deque(maxlen=256)
        self._ticks = 0
        self._raised = float(autopilot.seen.position_site[2]) - ground_site
        self._heard = self._listen()

    def state(self) -> VehicleState | None:
        """Newest telemetry."""
        seen, a = self._autopilot.seen, self._autopilot
        armed, mode, reasons = self._heard
        return VehicleState(
            time=seen.time,
            position_site=self._lowered(seen.position_site),
            velocity_site=seen.velocity_site,
            site_from_body=seen.site_from_body,
            angular_velocity_body=seen.rates_body,
            armed=armed,
            mode=mode.flight_mode,
            landed=a.landed,
            heard=seen.time,
            battery_share=a.craft.battery.share,
            battery_voltage=a.craft.battery_voltage,
            ready=not reasons,
            fixed=a.global_position_ok,
            not_ready=reasons,
        )

    def poses(self, since: float) -> tuple[Pose, ...]:
        """Poses after `since`, oldest first, of the last two seconds."""
        oldest = max(since, self._autopilot.time - POSE_HISTORY)
        return poses_after(self._poses, oldest)

    def send(self, setpoint: Setpoint) -> None:
        """Stream this setpoint from now on."""
        self._streaming = setpoint
        self._stream()

    def stop_sending(self) -> None:
        """End the stream."""
        self._streaming = None

    def command(self, command: Command, height: float = math.nan) -> None:
        """Carry it out at once; the answer is what MAVSDK would make of PX4's first one."""
        accepted, said = self._do(command, height)
        self._answers.append(Answer(command, accepted, said, self._autopilot.time))

    def pump(self, on: bool) -> None:
        """Run the pump, or stop it."""
        self._autopilot.craft.pumping = on

    def answers(self) -> tuple[Answer, ...]:
        """Answers since the last call."""
        taken, self._answers = tuple(self._answers), []
        return taken

    def close(self) -> None:
        """End the stream."""
        self.stop_sending()

    def before(self) -> None:
        """A tick begins: MAVSDK's own re-sending."""
        self._stream()

    def after(self) -> None:
        """A tick is over: hear what is told in it."""
        self._ticks += 1
        a = self._autopilot
        if not a.armed:
            self._raised = float(a.seen.position_site[2]) - self._ground_site
        if self._ticks % POSE_EVERY == 0:
            place = self._lowered(a.seen.position_site)
            self._poses.append(Pose(a.seen.time, place, a.seen.site_from_body))
        if self._ticks % HEARTBEAT_EVERY == 0:
            self._heard = self._listen()

    def _listen(self) -> tuple[bool, Mode, tuple[str, ...]]:
        a = self._autopilot
        return a.armed, a.mode, () if a.armed else a.not_ready()

    def _lowered(self, position_site: Vector) -> Vector:
        lowered = position_site.copy()
        lowered[2] -= self._raised
        return lowered

    def _stream(self) -> None:
        s = self._streaming
        if s is None:
            return
        position = s.position_site.copy()
        position[2] += self._raised
        self._autopilot.offboard(
            Wanted(
                self._autopilot.time, position, s.velocity_site, s.acceleration_site,
                s.yaw_site, math.nan,
            )
        )  # fmt: skip

    def _do(self, command: Command, height: float) -> tuple[bool, str]:
        a = self._autopilot
        reasons = a.not_ready()
        if command is Command.ARM:
            accepted = a.arm() is Result.ACCEPTED
            return accepted, "accepted" if accepted else f"COMMAND_DENIED {', '.join(reasons)}"
        if command is Command.DISARM:
            accepted = a.disarm() is Result.ACCEPTED
            return accepted, "accepted" if accepted else "COMMAND_DENIED"
        if command is Command.TAKEOFF:
            if math.isfinite(height):
                a.parameters.set("MIS_TAKEOFF_ALT", height)
            accepted = a.take_off() is Result.ACCEPTED
            return accepted, "accepted" if accepted else "COMMAND_DENIED"
        if command is Command.OFFBOARD and self._streaming is None:
            return False, "NO_SETPOINT_SET"
        done = a.set_mode(_MODES[command])
        if command is Command.LAND and done is not Result.ACCEPTED:
            return False, "COMMAND_DENIED"
        return True, "accepted"


class LockstepCamera:
    """Newest rendered frame."""

    def __init__(self, model: DepthCamera) -> None:
        self.model = model
        self.frame: DepthFrame | None = None

    def latest(self) -> DepthFrame | None:
        """The newest frame, once."""
        frame, self.frame = self.frame, None
        return frame

    def close(self) -> None:
        """Nothing to let go of."""


class LockstepSensors:
    """Newest scans."""

    def __init__(self) -> None:
        self.sensed = Sensed()

    def newest(self) -> Sensed:
        """The newest scan of each sensor."""
        return self.sensed


class LockstepTruth:
    """What really happened, at 50 Hz."""

    def __init__(self) -> None:
        self.records: list[TruthRecord] = []

    def take(self) -> tuple[TruthRecord, ...]:
        """Records since the last call."""
        taken, self.records = tuple(self.records), []
        return taken
