"""One thing that was looked at."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Verdict(Enum):
    """How bad it is."""

    OK = "ok"
    NOTE = "note"  # flies, but know it
    BAD = "bad"  # mend it before flying


@dataclass(frozen=True, slots=True)
class Finding:
    """What was found, what it should be, and how to mend it."""

    subject: str
    item: str
    found: str
    verdict: Verdict = Verdict.OK
    mend: str = ""


def judged(
    subject: str, item: str, found: str, ok: bool, mend: str, otherwise: Verdict = Verdict.BAD
) -> Finding:
    """A finding with its mend only where one is needed."""
    return Finding(subject, item, found, *((Verdict.OK, "") if ok else (otherwise, mend)))
