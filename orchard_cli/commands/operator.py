"""The human at the keyboard: Ctrl-C holds; then keys choose. Never a fall."""

from __future__ import annotations

import contextlib
import math
import os
import select
import signal
import sys
import termios
import time
import tty
from collections import deque
from collections.abc import Iterator
from types import FrameType

from orchard_cli.flight.safety import Request

KEYS = {
    "h": Request.HOLD,
    "c": Request.CONTINUE,
    "r": Request.RETURN,
    "l": Request.LAND,
}


ONE_WISH = 0.3  # s: signals nearer to each other are one wish that reached us two ways
_ASKING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_IGNORED = (signal.SIGTSTP, signal.SIGQUIT)  # a suspended program would be ended by the deadman


class Operator:
    """Fits flight/ports.py `Operator`.

    At a terminal the first Ctrl-C asks for a hold and the second for a landing. Without one there
    is nobody to choose, so a signal asks for a hold and then at once for `unattended`.
    """

    def __init__(self, unattended: Request = Request.RETURN) -> None:
        self._attended = sys.stdin is not None and sys.stdin.isatty()
        self._unattended = unattended
        self._asked: deque[Request] = deque()
        self._interrupts = 0
        self._interrupted = -math.inf  # s, when the last signal came

    @property
    def attended(self) -> bool:
        """Whether somebody sits at a terminal."""
        return self._attended

    def request(self) -> Request | None:
        """The oldest request that was not handed out yet."""
        if self._attended:
            with contextlib.suppress(OSError):  # a terminal that went away asks for nothing
                self._read_keys()
        request = self._asked.popleft() if self._asked else None
        if request is Request.CONTINUE:
            self._interrupts = 0  # the next Ctrl-C holds again
        return request

    def _read_keys(self) -> None:
        while select.select([sys.stdin], [], [], 0)[0]:
            key = os.read(sys.stdin.fileno(), 1).decode(errors="ignore").lower()
            if not key:
                return
            if key in KEYS:
                self._asked.append(KEYS[key])

    def interrupt(self, number: int, frame: FrameType | None) -> None:
        """Handle SIGINT and SIGTERM."""
        del frame
        again = time.monotonic() - self._interrupted < ONE_WISH
        self._interrupted = time.monotonic()
        if again:
            return
        self._interrupts += 1
        if self._interrupts > 1:
            self._asked.append(Request.LAND)
            return
        self._asked.append(Request.HOLD)
        if not self._attended or number == signal.SIGHUP:
            self._asked.append(self._unattended)

    @contextlib.contextmanager
    def listening(self) -> Iterator[Operator]:
        """Take over the signals, and the keys when there is a terminal; give both back."""
        before = {number: signal.signal(number, self.interrupt) for number in _ASKING}
        before |= {number: signal.signal(number, signal.SIG_IGN) for number in _IGNORED}
        modes = None
        if self._attended:
            modes = termios.tcgetattr(sys.stdin)
            tty.setcbreak(sys.stdin)
        try:
            yield self
        finally:
            if modes is not None:
                termios.tcsetattr(sys.stdin, termios.TCSADRAIN, modes)
            for number, handler in before.items():
                signal.signal(number, handler)
