"""The autopilot's end of a MAVLink link: messages in, messages out, no sockets and no clock."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import development as mav

from orchard_cli.model.site import SiteOrigin
from orchard_cli.simulator.autopilot import Autopilot, Result, Sticks, Wanted
from orchard_cli.simulator.faults import ClockStep, LinkFault, OriginMove

from .commands import Commands
from .earth import Earth, tell
from .missions import MissionProtocol
from .params import ParamProtocol
from .scope import Scope
from .streams import BUILDERS, Streams

LOCAL_NED, LOCAL_OFFSET, BODY_NED, BODY_OFFSET, BODY_FRD = 1, 7, 8, 9, 12  # MAV_FRAME
IGNORE_YAW, IGNORE_YAW_RATE = 1 << 10, 1 << 11
SET_INTERVAL, REQUEST_MESSAGE, GET_INTERVAL, SET_MODE, ARM = 511, 512, 510, 176, 400
STICKS_FULL = 1000.0


class Endpoint:
    """One autopilot on one link. `utc` is the Unix time of its boot, s."""

    def __init__(self, autopilot: Autopilot, origin: SiteOrigin, utc: float) -> None:
        self._autopilot = autopilot
        self.earth = Earth(origin, autopilot.craft.body.position_site)
        self.streams = Streams()
        self._commands = Commands(autopilot, self.earth)
        self._params = ParamProtocol(autopilot.parameters)
        self._missions = MissionProtocol(autopilot, self.earth)
        self._utc = utc
        self._ahead = 0.0  # s, of the stamps before the true time since boot
        self._system = int(autopilot.parameters["MAV_SYS_ID"])
        self._component = int(autopilot.parameters["MAV_COMP_ID"])
        self._table: dict[str, Callable[[Any], list[Any]]] = {
            "SET_POSITION_TARGET_LOCAL_NED": self._setpoint,
            "COMMAND_LONG": self._command,
            "COMMAND_INT": self._command,
            "MANUAL_CONTROL": self._sticks,
            "TIMESYNC": self._timesync,
            "PING": self._ping,
        }

    def _scope(self) -> Scope:
        a = self._autopilot
        seen = replace(a.seen, time=a.seen.time + self._ahead) if self._ahead else a.seen
        return Scope(a, self.earth, tell(self.earth, seen, a.home_site), self._utc)

    def inject(self, fault: LinkFault) -> None:
        """Make something go wrong on the link from now on."""
        match fault:
            case OriginMove():
                self.earth.move(np.array(fault.moved_site))
            case ClockStep():
                self._ahead += fault.seconds

    def tick(self) -> list[Any]:
        """Everything that is due now: streams and unfinished transfers."""
        now = self._autopilot.time
        ready = self.streams.due(now)
        told = self._missions.tick(now)
        if ready:
            scope = self._scope()
            built = (BUILDERS[number][0](scope) for number in ready)
            told += [message for message in built if message is not None]
        return told

    def handle(self, message: Any) -> list[Any]:
        """Act on one message from the client and return the answers to it."""
        if getattr(message, "target_system", self._system) not in (0, self._system):
            return []
        if getattr(message, "target_component", self._component) not in (0, self._component):
            return []
        act = self._table.get(message.get_type())
        if act is not None:
            return act(message)
        return self._params.handle(message) or self._missions.handle(message, self._autopilot.time)

    def _timesync(self, m: Any) -> list[Any]:
        if m.tc1 != 0:
            return []
        return [
            mav.MAVLink_timesync_message(round((self._autopilot.time + self._ahead) * 1e9), m.ts1)
        ]

    def _ping(self, m: Any) -> list[Any]:
        if m.target_system != 0:  # an answer to ours
            return []
        to = (m.get_srcSystem(), m.get_srcComponent())
        return [mav.MAVLink_ping_message(m.time_usec, m.seq, *to)]

    # -- commands

    def _command(self, message: Any) -> list[Any]:
        command, to = message.command, (message.get_srcSystem(), message.get_srcComponent())
        if message.get_type() == "COMMAND_INT":
            return [self._ack(command, self._commands.run_int(message), to)]
        m = message
        params = (m.param1, m.param2, m.param3, m.param4, m.param5, m.param6, m.param7)
        if command == SET_INTERVAL:
            done = self.streams.set_interval(int(m.param1), m.param2, self._autopilot.time)
            return [self._ack(command, Result.ACCEPTED if done else Result.FAILED, to)]
        if command == GET_INTERVAL:
            number = int(m.param1)
            interval = mav.MAVLink_message_interval_message(
                number, self.streams.interval_us(number)
            )
            return [self._ack(command, Result.ACCEPTED, to), interval]
        if command == REQUEST_MESSAGE:
            return self._requested(int(m.param1), to)
        reasons = self._autopilot.not_ready() if command == ARM else ()
        result = self._commands.run(command, params)
        answers = [self._ack(command, result, to)]
        if command == SET_MODE:
            # PX4's receiver says yes before its commander decides; clients believe the first.
            answers.insert(0, self._ack(command, Result.ACCEPTED, to))
        if command == ARM and params[0] == 1 and result is not Result.ACCEPTED:
            # PX4 gives its reasons as events, which need its metadata; here they are plain text.
            words = f"Arming denied: {', '.join(reasons)}"[:50]
            answers.append(mav.MAVLink_statustext_message(2, words.encode()))
        return answers

    def _requested(self, number: int, to: tuple[int, int]) -> list[Any]:
        message = BUILDERS[number][0](self._scope()) if number in BUILDERS else None
        result = Result.DENIED if message is None else Result.ACCEPTED
        ack = self._ack(REQUEST_MESSAGE, result, to)
        return [ack] if message is None else [message, ack]

    @staticmethod
    def _ack(command: int, result: Result, to: tuple[int, int]) -> Any:
        return mav.MAVLink_command_ack_message(command, int(result), 0, 0, *to)

    # -- setpoints and sticks

    def _setpoint(self, m: Any) -> list[Any]:
        """PX4's reading of the type mask: an ignored triple is not controlled."""
        position = _free(m.type_mask, 0, (m.x, m.y, m.z))
        velocity = _free(m.type_mask, 3, (m.vx, m.vy, m.vz))
        acceleration = _free(m.type_mask, 6, (m.afx, m.afy, m.afz))
        yaw = math.nan if m.type_mask & IGNORE_YAW else m.yaw
        yaw_rate = math.nan if m.type_mask & IGNORE_YAW_RATE else m.yaw_rate
        seen, earth = self._autopilot.seen, self.earth
        if m.coordinate_frame in (BODY_NED, BODY_FRD):
            heading = earth.yaw_site(seen.yaw_site)
            velocity, acceleration = _turn(velocity, heading), _turn(acceleration, heading)
            position = (math.nan, math.nan, math.nan)
        elif m.coordinate_frame != LOCAL_NED:
            return []  # PX4 takes no other frame either
        wanted = Wanted(
            self._autopilot.time,
            earth.site(*position),
            earth.vector_site(*velocity),
            earth.vector_site(*acceleration),
            earth.yaw_site(yaw) if math.isfinite(yaw) else math.nan,
            -yaw_rate,
        )
        nothing = all(
            math.isnan(value)
            for triple in (wanted.position_site, wanted.velocity_site, wanted.acceleration_site)
            for value in triple.tolist()
        )
        if not nothing:
            self._autopilot.offboard(wanted)
        return []

    def _sticks(self, m: Any) -> list[Any]:
        x, y, z, r = m.x / STICKS_FULL, m.y / STICKS_FULL, m.z / STICKS_FULL, m.r / STICKS_FULL
        self._autopilot.pilot(Sticks(self._autopilot.time, x, -y, 2 * z - 1, -r))
        return []


def _free(mask: int, shift: int, triple: tuple[float, float, float]) -> tuple[float, float, float]:
    """The triple with NaN where its bit of the mask says to ignore it."""
    x, y, z = (
        math.nan if mask >> (shift + axis) & 1 else value for axis, value in enumerate(triple)
    )
    return x, y, z


def _turn(triple: tuple[float, float, float], heading: float) -> tuple[float, float, float]:
    """From forward, right, down of a level body to north, east, down."""
    c, s = math.cos(heading), math.sin(heading)
    forward, right, down = triple
    return forward * c - right * s, forward * s + right * c, down
