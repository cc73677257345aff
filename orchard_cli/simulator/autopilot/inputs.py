"""What reaches the autopilot from outside, and how fresh it is."""

from __future__ import annotations

from .parameters import Parameters
from .steered import Sticks, Wanted

GPS_SETTLE = 2.9  # s from a fix to a global position (measured, px4/README §4)


class Inputs:
    """The newest setpoint, the pilot's sticks, and the GPS fix."""

    def __init__(self, values: Parameters) -> None:
        self.wanted: Wanted | None = None
        self.sticks: Sticks | None = None
        self.gps_fix = True
        self._values = values
        self._fix_since = -GPS_SETTLE

    def set_gps_fix(self, fix: bool, now: float) -> None:
        """Take or give the GPS fix."""
        if fix and not self.gps_fix:
            self._fix_since = now
        self.gps_fix = fix

    def position_ok(self, now: float) -> bool:
        """Whether there is a settled GPS fix."""
        return self.gps_fix and now - self._fix_since >= GPS_SETTLE

    def setpoints_alive(self, now: float) -> bool:
        """Whether the offboard stream is younger than COM_OF_LOSS_T."""
        return self.wanted is not None and now - self.wanted.time <= self._values["COM_OF_LOSS_T"]

    def pilot_alive(self, now: float) -> bool:
        """Whether sticks came within COM_RC_LOSS_T."""
        return self.sticks is not None and now - self.sticks.time <= self._values["COM_RC_LOSS_T"]
