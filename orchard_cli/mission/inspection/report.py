"""What an inspection found: each rule with its figure, its limit, and the place."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from orchard_cli.model.arrays import Array, Vector

from .flown import Flown

_MOST_PLACES = 10  # told of one rule


class Sense(Enum):
    """On which side of its limit a figure has to lie."""

    AT_LEAST = "at least"
    AT_MOST = "at most"


@dataclass(frozen=True, slots=True)
class Rule:
    """A limit that a mission has to keep."""

    name: str
    sense: Sense
    limit: float
    unit: str
    slack: float = 0.0  # in the rule's unit, granted for rounding and for the spline's own error

    def keeps(self, figure: float) -> bool:
        """Whether a figure is within the limit; NaN is not."""
        if self.sense is Sense.AT_LEAST:
            return figure >= self.limit - self.slack
        return figure <= self.limit + self.slack


@dataclass(frozen=True, slots=True, eq=False)
class Finding:
    """One rule judged, at its worst place or at one of the places where it is broken."""

    rule: Rule
    ok: bool
    figure: float  # in the rule's unit; infinite: nothing of the kind is near
    about: str = ""  # which tree, obstacle or stretch
    place_site: Vector | None = None  # (3,) m; None: the rule is about the whole flight
    time: float | None = None  # s since the trajectory's start


def judge_total(rule: Rule, figure: float, about: str = "") -> list[Finding]:
    """A rule about the whole flight."""
    return [Finding(rule, rule.keeps(figure), figure, about)]


def judge_along(
    rule: Rule, flown: Flown, figures: Array, about: list[str] | str = ""
) -> list[Finding]:
    """A rule about every moment: (n,) figures, one a sample of the flight.

    One finding for each stretch that breaks the rule, at its worst moment; when none does, one for
    the worst moment of all.
    """
    badness = -figures if rule.sense is Sense.AT_LEAST else figures
    badness = np.where(np.isnan(figures), np.inf, badness)
    broken = badness > (-rule.limit if rule.sense is Sense.AT_LEAST else rule.limit) + rule.slack

    def found(k: int) -> Finding:
        word = about if isinstance(about, str) else about[k]
        return Finding(
            rule,
            not bool(broken[k]),
            float(figures[k]),
            word,
            flown.positions[k],
            float(flown.times[k]),
        )

    if not broken.any():
        return [found(int(badness.argmax()))]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], broken, [False]]).astype(int)))
    spans = list(zip(edges[::2], edges[1::2], strict=True))
    worst = [int(a + badness[a:b].argmax()) for a, b in spans]
    worst = sorted(sorted(worst, key=lambda k: -badness[k])[:_MOST_PLACES])
    return [found(k) for k in worst]
