"""The human at the keyboard: Ctrl-C holds; then keys choose. Never a fall."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import termios
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


class Operator:
    """Fits flight/ports.py `Operator`.

    At a terminal the first Ctrl-C asks for a hold and the second for a landing. Without one there
    is nobody to choose, so a signal asks for a hold and then at once for `unattended`.
    """

    def __init__(self, unattended: Request = Request.RETURN) -> None:
        self._attended = sys.stdin.isatty()
        self._unattended = unattended
        self._asked: deque[Request] = deque()
        self._interrupts = 0

    @property
    def attended(self) -> bool:
        """Whether somebody sits at a terminal."""
        return self._attended

    def request(self) -> Request | None:
        """The oldest request that was not handed out yet."""
        if self._attended:
            while select.select([sys.stdin], [], [], 0)[0]:
                key = os.read(sys.stdin.fileno(), 1).decode(errors="ignore").lower()
                if not key:
                    break
                if key in KEYS:
                    self._asked.append(KEYS[key])
        return self._asked.popleft() if self._asked else None

    def interrupt(self, number: int, frame: FrameType | None) -> None:
        """Handle SIGINT and SIGTERM."""
        del number, frame
        self._interrupts += 1
        if self._interrupts > 1:
            self._asked.append(Request.LAND)
            return
        self._asked.append(Request.HOLD)
        if not self._attended:
            self._asked.append(self._unattended)

    @contextlib.contextmanager
    def listening(self) -> Iterator[Operator]:
        """Take over the signals, and the keys when there is a terminal; give both back."""
        before = {n: signal.signal(n, self.interrupt) for n in (signal.SIGINT, signal.SIGTERM)}
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
