"""One error tree. Each leaf carries the exit code and tells the user the mend."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that is wrong with an input: where it stands, what it is, how to mend it."""

    where: str
    what: str
    mend: str = ""

    def __str__(self) -> str:
        line = f"{self.where}: {self.what}" if self.where else self.what
        return _one_line(f"{line}; {self.mend}" if self.mend else line)


def _one_line(text: str) -> str:
    """What a hostile file says is quoted, not sent to the terminal: no line breaks, no controls."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


class OrchardError(Exception):
    """Anything that ends a command with a message and no traceback. A bare one is a bug."""

    exit_code = 1
    hint = ""


class InputError(OrchardError):
    """The user's input is wrong. Carries every fault found, not only the first."""

    exit_code = 2

    def __init__(self, faults: Fault | Iterable[Fault]) -> None:
        self.faults = (faults,) if isinstance(faults, Fault) else tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))


class FlightEndedEarly(OrchardError):
    """The flight ended in a safe state other than the planned one (held, returned, landed)."""

    exit_code = 3


class LinkError(OrchardError):
    """No link, no device, or the far end refused; the message says what the far end said."""

    exit_code = 4
