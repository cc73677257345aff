"""The deadman: the kernel ends this process when its control loop stops coming by.

MAVSDK re-sends the last setpoint at 20 Hz from a thread of its own, so a hung Python program would
fly on for ever. A guard inside Python hangs with it (the GIL may be held). SIGALRM at its default
action needs no Python: when the timer is not re-armed in time, the kernel ends the process, the
stream ends with it, and the autopilot's own offboard-loss failsafe acts (COM_OF_LOSS_T later).
"""

from __future__ import annotations

import signal


class Deadman:
    """Re-arm with `feed` once a control cycle; `disarm` when nothing is being streamed."""

    def __init__(self, limit: float) -> None:
        """`limit` is in seconds of real time. Call from the main thread."""
        self._limit = limit
        signal.signal(signal.SIGALRM, signal.SIG_DFL)

    def feed(self) -> None:
        """The loop is alive: give it another `limit` seconds."""
        signal.setitimer(signal.ITIMER_REAL, self._limit)

    def disarm(self) -> None:
        """Nothing flies by this process any more."""
        signal.setitimer(signal.ITIMER_REAL, 0.0)
