"""PX4's flight modes and answers, as MAVLink numbers them."""

from __future__ import annotations

from enum import Enum, IntEnum

from orchard_cli.model.vehicle import FlightMode


class Mode(Enum):
    """A navigation state; the value is PX4's (main, sub) mode."""

    POSCTL = (3, 0)
    TAKEOFF = (4, 2)
    HOLD = (4, 3)
    MISSION = (4, 4)
    RETURN = (4, 5)
    LAND = (4, 6)
    OFFBOARD = (6, 0)

    @property
    def custom(self) -> int:
        """HEARTBEAT.custom_mode."""
        main, sub = self.value
        return main << 16 | sub << 24

    @property
    def standard(self) -> int:
        """CURRENT_MODE.standard_mode; 0 for a mode that has none."""
        return _STANDARD.get(self, 0)

    @property
    def arms(self) -> bool:
        """Whether the vehicle may be armed in it, and is left in it when it disarms."""
        return self not in (Mode.LAND, Mode.RETURN)

    @property
    def flight_mode(self) -> FlightMode:
        """The same in the flight's words."""
        return _FLIGHT_MODES[self]


_STANDARD = {Mode.POSCTL: 1, Mode.RETURN: 5, Mode.MISSION: 6, Mode.LAND: 7, Mode.TAKEOFF: 8}
_FLIGHT_MODES = {
    Mode.POSCTL: FlightMode.PILOT,
    Mode.TAKEOFF: FlightMode.TAKEOFF,
    Mode.HOLD: FlightMode.HOLD,
    Mode.MISSION: FlightMode.MISSION,
    Mode.RETURN: FlightMode.RETURN,
    Mode.LAND: FlightMode.LAND,
    Mode.OFFBOARD: FlightMode.OFFBOARD,
}


class Result(IntEnum):
    """MAV_RESULT. Never above 6: MAVSDK hangs on those (px4/README, 5.2), PX4 sends one such, 9."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4
    UNSUPPORTED_FRAME = 9
