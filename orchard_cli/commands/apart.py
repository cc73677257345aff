"""A flight in a process of its own, and one beside it that outlives it.

The deadman ends a flight process that hangs, and anything may kill it. Nobody would then give the
terminal back, say what happened, or print the JSON document that a script waits for. So the
command splits in two before anything else is loaded: the child flies; the parent only waits, hands
on signals, and speaks when the child can no longer do it.
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

EXIT_CODE = 4
WHY = {
    signal.SIGALRM: "the flight program hung and was ended",
    signal.SIGKILL: "the flight program was killed, by somebody or for want of memory",
}
NEXT = (
    "nothing is sent any more and the autopilot's own failsafe acts: "
    "watch the vehicle and be ready to take over"
)
_PARENT_DIED = 1  # PR_SET_PDEATHSIG of prctl(2)
_SHOW_CURSOR = "\x1b[?25h"
_HANDED_ON = (signal.SIGTERM, signal.SIGHUP)
_QUIET = (signal.SIGTERM, signal.SIGHUP, signal.SIGINT)  # they end a child that does not fly yet


def fly_apart(
    as_json: bool, document: Callable[[dict[str, Any]], dict[str, Any]] = dict
) -> Callable[[Path], None]:
    """Return in the child only, with a function that tells the parent the log's name.

    The parent ends with the child's exit code. When a signal ended the child, it gives the
    terminal back, says what happened, prints `document` of the flight's summary where `as_json`
    asks for it, and ends with EXIT_CODE.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    reader, writer = os.pipe()
    parent = os.getpid()
    child = os.fork()
    if child == 0:
        os.close(reader)
        _end_with(parent)
        return lambda log: _tell(writer, log)
    os.close(writer)
    with _terminal_kept(), _signals_handed_on(child):
        log = _listen(reader)
        _, status = os.waitpid(child, 0)
    code = os.waitstatus_to_exitcode(status)
    if code >= 0:
        raise SystemExit(code)
    number = signal.Signals(-code)
    if number in _QUIET:
        raise SystemExit(128 + number)
    _speak(number, log, as_json, document)
    raise SystemExit(EXIT_CODE)


def _speak(
    number: signal.Signals,
    log: str | None,
    as_json: bool,
    document: Callable[[dict[str, Any]], dict[str, Any]],
) -> None:
    why = WHY.get(number, f"the flight program crashed ({number.name})")
    kept = f"; log up to its last half second: {log}" if log else ""
    sys.stderr.write(f"\norchard: {why}; {NEXT}{kept}\n")
    if as_json:
        summary = {
            "as_planned": False,
            "ended": why,
            "flight_s": None,
            "speed_factor": None,
            "log": log,
            "log_losses": {},
        }
        print(json.dumps(document(summary)))


def _tell(writer: int, log: Path) -> None:
    with contextlib.suppress(OSError):  # a parent that died needs it no more
        os.write(writer, str(log).encode())
        os.close(writer)


def _listen(reader: int) -> str | None:
    """What the child told; returns when it has told it, or has ended."""
    with open(reader, "rb") as pipe:
        return pipe.read().decode() or None


def _end_with(parent: int) -> None:
    """A parent that dies asks its child to end the flight: hold, then home."""
    ctypes.CDLL(None).prctl(_PARENT_DIED, signal.SIGTERM)
    if os.getppid() != parent:  # it died before that
        os.kill(os.getpid(), signal.SIGTERM)


@contextlib.contextmanager
def _signals_handed_on(child: int) -> Iterator[None]:
    """What is sent to this process alone goes to the child; a terminal's keys reach both."""

    def hand_on(number: int, _: object) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, number)

    handled: dict[int, Any] = dict.fromkeys((signal.SIGTSTP, signal.SIGQUIT), signal.SIG_IGN)
    handled |= dict.fromkeys(_HANDED_ON, hand_on)
    handled[signal.SIGINT] = signal.SIG_IGN if _at_terminal() else hand_on
    before = {number: signal.signal(number, act) for number, act in handled.items()}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextlib.contextmanager
def _terminal_kept() -> Iterator[None]:
    """Afterwards the terminal is as it was: its modes, and a cursor that can be seen."""
    import termios

    modes = termios.tcgetattr(sys.stdin) if _at_terminal() else None
    try:
        yield
    finally:
        if modes is not None:
            with contextlib.suppress(termios.error):
                termios.tcsetattr(sys.stdin, termios.TCSANOW, modes)
        if sys.stderr.isatty():
            sys.stderr.write(_SHOW_CURSOR)


def _at_terminal() -> bool:
    return sys.stdin is not None and sys.stdin.isatty()
