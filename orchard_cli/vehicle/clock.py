"""The flight clock of a real vehicle."""

from __future__ import annotations

import time

LONGEST_SLEEP = 0.1  # s: whoever waits looks up at least this often


class MonotonicClock:
    """Fits flight/ports.py `Clock`: the operating system's monotonic clock."""

    def now(self) -> float:
        """Seconds."""
        return time.monotonic()

    def sleep_until(self, time_s: float) -> None:
        """Sleep until `time_s` of this clock, at most LONGEST_SLEEP."""
        wait = time_s - time.monotonic()
        if wait > 0:
            time.sleep(min(wait, LONGEST_SLEEP))
