"""Stands between an autopilot and its client: can be cut, listens to both, and can speak itself.

What it hears is evidence that owes nothing to the flight code: mode and arming as the autopilot
tells them, when the client last sent a setpoint, and what it asked for.
"""

from __future__ import annotations

import contextlib
import selectors
import socket
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from pymavlink.dialects.v20 import development as mav

from orchard_cli.simulator.autopilot import Mode

HOST = "127.0.0.1"
STATION = (255, 190)  # system and component of a ground station
_ARMED = 128
_MODES = {mode.custom: mode.flight_mode.value for mode in Mode}
_ASKED = {20: "return", 21: "land", 22: "takeoff", 176: "mode", 187: "pump", 400: "arm"}


@dataclass(slots=True)
class Heard:
    """What went by; times are on the simulated clock, s."""

    mode: str = "unknown"
    armed: bool = False
    fix: int = 0  # GPS_FIX_TYPE
    battery: float = 1.0  # share left
    boot_s: float = 0.0  # the autopilot's own clock
    position_ned: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m, as it believes
    setpoint_at: float = -1.0  # when the client's newest setpoint went by
    asked: list[tuple[float, str]] = field(default_factory=list)  # by the client
    carried: int = 0  # datagrams from the autopilot
    carried_at: float = -1.0


class Relay:
    """Carries datagrams both ways in a thread until it is closed."""

    def __init__(self, now: Callable[[], float], client_port: int) -> None:
        """`now` is the simulated clock; the client listens on `client_port`."""
        self.heard = Heard()
        self.whole = threading.Event()  # cleared: the link is cut
        self.whole.set()
        self._now = now
        self._client = (HOST, client_port)
        self._vehicle: Any = None
        self._air, self._ground = (_socket() for _ in range(2))
        self.port = int(self._air.getsockname()[1])  # where the autopilot sends to
        self._ended = threading.Event()
        self._down, self._up = _parser(), _parser()
        self._station = mav.MAVLink(None, srcSystem=STATION[0], srcComponent=STATION[1])
        self._thread = threading.Thread(target=self._carry, name="relay", daemon=True)
        self._thread.start()

    def say(self, *messages: Any) -> None:
        """Speak to the autopilot as another ground station, cut or not."""
        if self._vehicle is not None:
            for message in messages:
                self._air.sendto(message.pack(self._station), self._vehicle)

    def babble(self, data: bytes) -> None:
        """Send bytes that are no message to both ends."""
        if self._vehicle is not None:
            self._air.sendto(data, self._vehicle)
        self._ground.sendto(data, self._client)

    def take_over(self, mode: str) -> None:
        """As a ground station: ask for hold, return or land; as a pilot, take the sticks."""
        wanted = next(m for m in Mode if m.flight_mode.value == mode)
        main, sub = wanted.value
        self.say(mav.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
        if mode == "pilot":
            self.say(mav.MAVLink_manual_control_message(1, 0, 0, 500, 0, 0))
        self.say(mav.MAVLink_command_long_message(1, 1, 176, 0, 1, main, sub, 0, 0, 0, 0))

    def sticks(self) -> None:
        """The pilot's sticks, at rest."""
        self.say(mav.MAVLink_manual_control_message(1, 0, 0, 500, 0, 0))

    def kill_motors(self) -> None:
        """Disarm by force, whatever the checks say."""
        self.say(mav.MAVLink_command_long_message(1, 1, 400, 0, 0, 21196, 0, 0, 0, 0, 0))

    def close(self) -> None:
        """Carry nothing any more."""
        self._ended.set()
        self._thread.join(2.0)
        self._air.close()
        self._ground.close()

    def _carry(self) -> None:
        with selectors.DefaultSelector() as ready:
            ready.register(self._air, selectors.EVENT_READ, self._from_vehicle)
            ready.register(self._ground, selectors.EVENT_READ, self._from_client)
            while not self._ended.is_set():
                for key, _ in ready.select(0.1):
                    with contextlib.suppress(OSError):
                        key.data()

    def _from_vehicle(self) -> None:
        data, self._vehicle = self._air.recvfrom(65535)
        for message in self._down.parse_buffer(data) or ():
            self._note(message)
        if self.whole.is_set():
            self.heard.carried += 1
            self.heard.carried_at = self._now()
            self._ground.sendto(data, self._client)

    def _from_client(self) -> None:
        data, _ = self._ground.recvfrom(65535)
        if not self.whole.is_set() or self._vehicle is None:
            return
        for message in self._up.parse_buffer(data) or ():
            self._note_client(message)
        self._air.sendto(data, self._vehicle)

    def _note(self, m: Any) -> None:
        heard = self.heard
        match m.get_type():
            case "HEARTBEAT":
                heard.mode = _MODES.get(m.custom_mode, "unknown")
                heard.armed = bool(m.base_mode & _ARMED)
            case "GPS_RAW_INT":
                heard.fix = m.fix_type
            case "BATTERY_STATUS":
                heard.battery = m.battery_remaining / 100
            case "ODOMETRY":
                heard.boot_s = m.time_usec * 1e-6
                heard.position_ned = (m.x, m.y, m.z)

    def _note_client(self, m: Any) -> None:
        match m.get_type():
            case "SET_POSITION_TARGET_LOCAL_NED":
                self.heard.setpoint_at = self._now()
            case "COMMAND_LONG" if m.command in _ASKED:
                self.heard.asked.append((self._now(), _ASKED[m.command]))


def _socket() -> socket.socket:
    end = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    end.bind((HOST, 0))
    return end


def _parser() -> Any:
    parser = mav.MAVLink(None)
    parser.robust_parsing = True
    return parser


def free_port() -> int:
    """A UDP port that nobody uses now."""
    with _socket() as probe:
        return int(probe.getsockname()[1])
