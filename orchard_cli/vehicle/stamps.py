"""From the autopilot's time stamps to the flight clock."""

from __future__ import annotations

import math


class StampClock:
    """Learns the offset between a far clock and the flight clock from arrivals.

    A message cannot arrive before it was sent, so the smallest (arrival - stamp) seen lately is
    the best guess of the offset; later arrivals were delayed on the way. Two half windows keep
    the guess fresh when the clocks drift apart. A stamp that falls back by more than a second
    means that the far end rebooted: all that was learnt is dropped.
    """

    def __init__(self, window: float = 10.0) -> None:
        self._half = window / 2
        self._reset(-math.inf)

    def _reset(self, arrived: float) -> None:
        self._newest_stamp = -math.inf
        self._since = arrived
        self._smallest = math.inf
        self._smallest_before = math.inf

    def flight_time(self, stamp: float, arrived: float) -> float:
        """When the message was stamped, in flight-clock seconds; never after its arrival."""
        if stamp < self._newest_stamp - 1.0:
            self._reset(arrived)
        self._newest_stamp = max(self._newest_stamp, stamp)
        if arrived - self._since > self._half:
            self._smallest_before, self._smallest = self._smallest, math.inf
            self._since = arrived
        self._smallest = min(self._smallest, arrived - stamp)
        return stamp + min(self._smallest, self._smallest_before)
