"""The vehicle socket on MAVSDK 4: connect, stream setpoints, ask for things.

The only file besides telemetry.py that imports mavsdk. Blocking calls run one after the other in a
thread of their own; setpoints go straight through (3 µs). That a command was carried out is never
read from its result (PX4 acknowledges mode changes before it decides): see `state().mode`.
"""

from __future__ import annotations

import contextlib
import queue
import threading
from collections import deque
from collections.abc import Callable
from typing import Any

import mavsdk
import numpy as np
from mavsdk.plugins.action import Action
from mavsdk.plugins.events import Events
from mavsdk.plugins.offboard import (
    AccelerationNed,
    Offboard,
    PositionNedYaw,
    VelocityNedYaw,
)
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import Telemetry

from orchard_cli.errors import LinkError
from orchard_cli.model.sensors import corner_lasers
from orchard_cli.model.site import SiteOrigin
from orchard_cli.model.vehicle import Answer, Command, Pose, Setpoint, VehicleState

from .failsafes import Finding, judge, rules
from .origin import LocalOrigin, Place
from .port_lock import PortLock
from .rangefinders import Rangefinders
from .telemetry import TelemetryFeed

Now = Callable[[], float]
_URGENT = (Command.HOLD, Command.LAND, Command.DISARM)
FIX_PATIENCE = 45.0  # s of real time for the autopilot's first fix

_RATES = (  # Hz; what is not needed is turned down, so that the link carries what is
    ("set_rate_odometry", 50.0),
    ("set_rate_position_velocity_ned", 50.0),
    ("set_rate_landed_state", 10.0),
    ("set_rate_battery", 2.0),
    ("set_rate_attitude_euler", 10.0),
    ("set_rate_attitude_quaternion", 10.0),
    ("set_rate_position", 5.0),
    ("set_rate_imu", 5.0),
)


def connect(
    url: str, origin: SiteOrigin, now: Now, ground_site: float = 0.0, patience: float = 15.0
) -> MavsdkVehicle:
    """Wait up to `patience` s of real time for an autopilot on a MAVSDK connection URL.

    `ground_site` is the z in the site frame, m, of the ground that the disarmed vehicle stands on.

    Raises LinkError with what was waited for when none answers.
    """
    lock = PortLock(url)
    mavsdk.log_subscribe(lambda *_: True)  # its coloured lines would break --json
    configuration = mavsdk.Configuration.create_with_component_type(
        mavsdk.ComponentType.COMPANION_COMPUTER
    )
    hub = mavsdk.Mavsdk(configuration)
    try:
        system = first_autopilot(hub, url, patience)
        return MavsdkVehicle(hub, system, Place(origin, ground_site), now, lock)
    except BaseException:
        hub.destroy()
        lock.release()
        raise


def first_autopilot(hub: mavsdk.Mavsdk, url: str, patience: float) -> Any:
    """Open a connection and wait for a heartbeat. Raises LinkError when none comes."""
    opened = hub.add_any_connection(url)
    if opened is not mavsdk.ConnectionResult.SUCCESS:
        raise LinkError(
            f"cannot open {url}: {opened.name}; URLs look like udpin://0.0.0.0:14540, "
            "tcpout://HOST:PORT or serial:///dev/ttyUSB0:921600"
        )
    system = hub.first_autopilot(patience)
    if system is None:
        raise LinkError(
            f"no heartbeat on {url} within {patience:.0f} s; is the autopilot on, "
            "and does it send to this port?"
        )
    return system


class MavsdkVehicle:
    """Fits flight/ports.py `Vehicle`."""

    def __init__(
        self, hub: mavsdk.Mavsdk, system: Any, place: Place, now: Now, lock: PortLock
    ) -> None:
        self._hub = hub
        self._lock = lock
        self._now = now
        self._system = system
        self._action = Action(system)
        self._param = Param(system)
        self._events = Events(system)
        self._offboard: Any = Offboard(system)
        self._telemetry = Telemetry(system)
        self._local = LocalOrigin(self._telemetry, place)
        self._frame = self._local.wait(FIX_PATIENCE)
        self._feed = TelemetryFeed(self._telemetry, self._frame, now)
        self._rangefinders: Rangefinders | None = None
        self._answers: deque[Answer] = deque()
        self._wishes: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._worker = threading.Thread(target=self._work, name="vehicle-commands", daemon=True)
        self._worker.start()
        self._local.watch()
        system.subscribe_is_connected(self._on_connected)
        self._on_connected(True, None)

    def state(self) -> VehicleState | None:
        """Newest telemetry, in the site frame.

        Where the local origin was found to have moved, the frame changes here and nowhere else:
        what is sent next is in the same frame as what was told last.
        """
        move = self._local.take()
        if move is not None:
            self._frame = move.frame
            self._feed.reframe(move.frame, move.sunk)
        return self._feed.state()

    def poses(self, since: float) -> tuple[Pose, ...]:
        """Poses measured after `since`."""
        return self._feed.poses(since)

    def newest_pose(self) -> Pose | None:
        """The newest pose heard."""
        state = self._feed.state()
        return None if state is None else state.pose

    def send(self, setpoint: Setpoint) -> None:
        """Stream position, velocity, acceleration and yaw."""
        if self._offboard is None:
            self._offboard = Offboard(self._system)
        p = self._frame.position_ned(setpoint.position_site)
        v = self._frame.vector_ned(setpoint.velocity_site)
        a = self._frame.vector_ned(setpoint.acceleration_site)
        yaw = float(np.degrees(self._frame.yaw_ned(setpoint.yaw_site)))
        down = float(p[2]) + self._feed.ground_down
        self._offboard.set_position_velocity_acceleration_ned(
            PositionNedYaw(float(p[0]), float(p[1]), down, yaw),
            VelocityNedYaw(float(v[0]), float(v[1]), float(v[2]), yaw),
            AccelerationNed(float(a[0]), float(a[1]), float(a[2])),
        )

    def stop_sending(self) -> None:
        """End MAVSDK's own re-sending too: only destroying the plugin does."""
        offboard, self._offboard = self._offboard, None
        if offboard is not None:
            offboard.destroy()

    def command(self, command: Command, height: float = float("nan")) -> None:
        """Queue a command; its answer comes through `answers`.

        What ends a flight does not wait behind what was asked before it.
        """
        if command in _URGENT:
            self._forget_wishes()
        self._wishes.put(lambda: self._carry_out(command, height))

    def _forget_wishes(self) -> None:
        with contextlib.suppress(queue.Empty):
            while True:
                self._wishes.get_nowait()

    def pump(self, on: bool) -> None:
        """Set the autopilot's first actuator: full, or off. A refusal is told like a command's."""
        self._wishes.put(lambda: self._switch(on))

    def answers(self) -> tuple[Answer, ...]:
        """Answers since the last call."""
        taken = []
        while self._answers:
            taken.append(self._answers.popleft())
        return tuple(taken)

    def unsafe_failsafes(self, flight_height: float) -> tuple[Finding, ...]:
        """Failsafe parameters that are missing or unsafe. Blocks; call before arming."""
        values = {rule.name: self._read(rule.name, rule.is_float) for rule in rules(flight_height)}
        return judge(values, flight_height)

    def mend_failsafes(self, findings: tuple[Finding, ...]) -> None:
        """Write the wanted values. Blocks. Raises LinkError naming what was refused."""
        for finding in findings:
            try:
                if finding.is_float:
                    self._param.set_param_float(finding.name, float(finding.wanted))
                else:
                    self._param.set_param_int(finding.name, int(finding.wanted))
            except mavsdk.MavsdkError as error:
                raise LinkError(f"could not set {finding.name}: {error.result.name}") from error

    def rangefinders(self, arm: float) -> Rangefinders:
        """The radar and the lasers that the autopilot passes on; `arm`: m, where they sit."""
        if self._rangefinders is None:
            self._rangefinders = Rangefinders(self._system, self._now, arm, corner_lasers(arm))
        return self._rangefinders

    def close(self) -> None:
        """Stop the stream and let go of the link."""
        if self._rangefinders is not None:
            self._rangefinders.close()
        self._local.close()
        self._wishes.put(None)
        self._worker.join(timeout=5.0)
        self._hub.destroy()
        self._lock.release()

    def _read(self, name: str, is_float: bool) -> float | None:
        read = self._param.get_param_float if is_float else self._param.get_param_int
        try:
            return float(read(name))
        except mavsdk.MavsdkError:
            return None

    def _on_connected(self, connected: bool, _: Any) -> None:
        """An autopilot that rebooted has forgotten its rates; commands do not wait for them."""
        if connected:
            threading.Thread(target=self._set_rates, name="vehicle-rates", daemon=True).start()

    def _set_rates(self) -> None:
        for name, rate in _RATES:
            try:
                getattr(self._telemetry, name)(rate)
            except (mavsdk.MavsdkError, RuntimeError):
                continue  # the stream stays at the autopilot's own rate, or the link is closed

    def _work(self) -> None:
        while (wish := self._wishes.get()) is not None:
            wish()

    def _carry_out(self, command: Command, height: float) -> None:
        try:
            self._ask(command, height)
            accepted, said = True, "accepted"
        except mavsdk.MavsdkError as error:
            accepted, said = False, " ".join((error.result.name, *self._reasons(command)))
        except Exception as error:  # this thread must outlive anything: LAND comes through it
            accepted, said = False, f"{type(error).__name__}: {error}"
        self._answers.append(Answer(command, accepted, said, self._now()))

    def _switch(self, on: bool) -> None:
        with contextlib.suppress(mavsdk.MavsdkError):
            self._action.set_actuator(1, 1.0 if on else -1.0)

    def _ask(self, command: Command, height: float) -> None:
        if command is Command.TAKEOFF:
            self._action.set_takeoff_altitude(float(height))
            self._action.takeoff()
        elif command is Command.OFFBOARD:
            offboard = self._offboard
            if offboard is not None:  # else the stream was stopped since this was asked
                offboard.start()
        else:
            {
                Command.ARM: self._action.arm,
                Command.DISARM: self._action.disarm,
                Command.HOLD: self._action.hold,
                Command.RETURN: self._action.return_to_launch,
                Command.LAND: self._action.land,
            }[command]()

    def _reasons(self, command: Command) -> tuple[str, ...]:
        """The autopilot's own words for a refusal to arm, where it gives any."""
        if command is not Command.ARM:
            return ()
        try:
            report = self._events.get_health_and_arming_checks_report()
        except mavsdk.MavsdkError:
            return ()
        return tuple(problem.message for problem in report.all_problems)
