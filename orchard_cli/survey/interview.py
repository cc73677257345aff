"""The questions of a survey by tape, one after another, and the answers as survey tables.

What was answered is a list of texts, in the order of the questions; the next question follows from
it alone. So going back is taking the last one away, and a draft is the list in a file.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from orchard_cli.errors import Fault

from .tables import FARTHEST, MOST_ROWS, MOST_TREES

Answer = float | list[float] | str
DRAFT = "orchard-survey-draft"


class NotUnderstood(ValueError):
    """An answer that cannot be; the message says what is wanted."""


@dataclass(frozen=True, slots=True)
class Question:
    """One thing to ask."""

    key: str  # of the survey's table
    text: str
    read: Callable[[str], Answer]
    usual: str = ""  # taken for an empty answer; "": an answer is needed


def _number(low: float, high: float) -> Callable[[str], float]:
    def read(text: str) -> float:
        value = _float(text)
        if not low <= value <= high:
            raise NotUnderstood(f"give a number from {low:g} to {high:g}")
        return value

    return read


def _name(text: str) -> str:
    if not text.isprintable() or not 0 < len(text) <= 200:
        raise NotUnderstood("give a name of 1 to 200 letters")
    return text


def _float(text: str) -> float:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return math.nan


def numbers(text: str, low: float, high: float, most: int) -> list[float]:
    """`3.0 2.8 4x3,1`: 3.0, 2.8 and four times 3.1. Raises NotUnderstood."""
    found: list[float] = []
    for word in text.replace(";", " ").split():
        count, times, value = word.rpartition("x")
        many = int(count) if times and count.isdecimal() and len(count) < 6 else 1
        number = _float(value if times and count.isdecimal() else word)
        if not low <= number <= high:
            raise NotUnderstood(f"{word!r} is no number from {low:g} to {high:g}")
        if len(found) + many > most:
            raise NotUnderstood(f"at most {most} numbers")
        found += [number] * many
    if not found:
        raise NotUnderstood("give numbers with spaces between, like 3.0 2.8 4x3.1")
    return found


def _gaps(text: str) -> list[float]:
    return numbers(text, 0.1, 200, MOST_TREES - 1)


def _heights(gaps: str) -> Callable[[str], Answer]:
    trees = len(_gaps(gaps)) + 1

    def read(text: str) -> Answer:
        heights = numbers(text, 0.2, 60, MOST_TREES)
        if len(heights) == 1:
            return heights[0]
        if len(heights) != trees:
            raise NotUnderstood(f"give one height for all, or {trees}, one a tree")
        return heights

    return read


HEAD = (
    Question("name", "Name of the orchard", _name, "orchard"),
    Question("latitude_deg", "Latitude of the first tree, degrees (north +)", _number(-90, 90)),
    Question("longitude_deg", "Longitude of the first tree, degrees (east +)", _number(-180, 180)),
    Question("ground_m", "Ground above sea level there, m", _number(-500, 9_000)),
    Question(
        "heading_deg",
        "Compass heading along row 1, degrees (the other rows lie to the LEFT)",
        _number(-360, 360),
    ),
    Question("height_m", "Flight height above ground, m", _number(0.5, 100)),
    Question("speed_m_s", "Greatest speed, m/s", _number(0.1, 10), "1.0"),
)


def row_questions(k: int, row: list[str], before: list[str] | None) -> Question | None:
    """The next question about row `k`, from 1; None when all are answered.

    `before` are the answers of the row before, whose heights are taken for the same again.
    """
    number = f"Row {k}: "
    usual = before[-1] if before else ""
    usual = usual if len(usual.split()) == 1 else ""
    asked = [
        Question("gaps_m", number + "gaps from tree to tree, m (3.0 2.8 4x3.1)", _gaps),
        None,  # the heights: how many there may be, the gaps tell
    ]
    if k > 1:
        asked[:0] = [
            Question("distance_m", number + f"distance from row {k - 1}, m", _number(0.5, 200)),
            Question(
                "start_m",
                number + "start along x from the first tree of row 1, m",
                _number(-FARTHEST, FARTHEST),
                "0",
            ),
        ]
    if len(row) >= len(asked):
        return None
    question = asked[len(row)]
    if question is not None:
        return question
    text = number + "tree height, m (one for all, or one a tree)"
    return Question("tree_height_m", text, _heights(row[-1]), usual)


@dataclass(slots=True)
class Interview:
    """What was answered so far."""

    head: list[str] = field(default_factory=list)
    rows: list[list[str]] = field(default_factory=list)  # the last one may be begun only
    more: bool = True  # whether another row is asked for

    def question(self) -> Question | None:
        """The next one; None when there is nothing left to ask."""
        if len(self.head) < len(HEAD):
            return HEAD[len(self.head)]
        if not self.rows:
            self.rows.append([])
        before = self.rows[-2] if len(self.rows) > 1 else None
        asked = row_questions(len(self.rows), self.rows[-1], before)
        if asked is not None or not self.more:
            return asked
        if len(self.rows) >= MOST_ROWS:
            return None
        self.rows.append([])
        return row_questions(len(self.rows), [], self.rows[-2])

    def answer(self, text: str) -> None:
        """Take an answer. Raises NotUnderstood."""
        asked = self.question()
        if asked is None:
            return
        text = text.strip() or asked.usual
        if not text and asked.key == "distance_m":  # no more rows
            self.rows.pop()
            self.more = False
            return
        asked.read(text)
        (self.head if len(self.head) < len(HEAD) else self.rows[-1]).append(text)

    def back(self) -> None:
        """Take the last answer away."""
        self.question()
        while self.rows and not self.rows[-1]:
            self.rows.pop()
        (self.rows[-1] if self.rows else self.head)[-1:] = []

    def tables(self) -> dict[str, Any]:
        """The survey's tables; all questions must be answered."""
        head = {q.key: q.read(a) for q, a in zip(HEAD, self.head, strict=True)}
        site = ("latitude_deg", "longitude_deg", "heading_deg")
        return {
            "name": head["name"],
            "site": {**{key: head[key] for key in site}, "height_m": head["ground_m"]},
            "flight": {"height_m": head["height_m"], "speed_m_s": head["speed_m_s"]},
            "row": [_row_table(k, row) for k, row in enumerate(self.rows, 1) if row],
        }

    def draft(self) -> str:
        """All of it as text."""
        return json.dumps({"schema": DRAFT, "head": self.head, "rows": self.rows})


def _row_table(k: int, row: list[str]) -> dict[str, Answer]:
    table: dict[str, Answer] = {}
    for at, text in enumerate(row):
        if (asked := row_questions(k, row[:at], None)) is not None:
            table[asked.key] = asked.read(text)
    return table


def from_draft(text: str) -> Interview | Fault:
    """An interview from its draft, answer by answer, as far as they can be understood."""
    try:
        told = json.loads(text)
        answers = [*told["head"], *(a for row in told["rows"] for a in row)]
        if told["schema"] != DRAFT or not all(isinstance(a, str) and a for a in answers):
            raise ValueError("other things than answers")
        interview = Interview()
        for answer in answers[: MOST_ROWS * 4]:
            interview.answer(answer)
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        return Fault("draft", f"is none: {error}")
    return interview
