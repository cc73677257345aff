"""Rows from bare tree positions: guess, follow, fit, judge."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array, Indices, Points

from .follow import common_curve
from .mixture import Rows, fits
from .search import Guess, guesses

MOST_TREES = 20_000
_WRONG = 0.12  # share of trees in wrong rows, expected: more is too many
_RIVAL = 6.0  # nats by which another reading must be worse
_SAME = 0.05  # share of trees in which two readings of the same rows may differ
_APART = 0.15  # share of trees in no row
_SCATTER_MOST = 1.8  # m
_SPACING_LEAST = 3.75  # scatters between rows


@dataclass(frozen=True, slots=True, eq=False)
class FoundRows:
    """Rows as found, from right to left when looking along `direction`."""

    direction: float  # rad, of the rows, from +x towards +y
    rows: tuple[Indices, ...]  # each (n,) indices of trees, in order along the direction
    apart: Indices  # (n,) of trees in no row
    on_rows: Points  # (n, 2) m: each tree moved square to the direction onto its row's curve
    spacing: float  # m, median between neighbouring rows; 0 for one row
    scatter: float  # m, standard deviation of trees about their rows
    doubt: float  # share of trees expected in a wrong row
    why_not: tuple[str, ...]  # why these rows should not be trusted; empty: they can


@dataclass(frozen=True, slots=True, eq=False)
class _Reading:
    guess: Guess
    rows: Rows
    u: Array
    curve: Array

    @property
    def score(self) -> float:
        """Nats."""
        return self.rows.score


def find_rows(points: Points, towards: float | None = None) -> FoundRows | None:
    """Rows of trees at (n, 2) m; None when there are too few trees or nothing fits.

    `towards` is the rows' direction where it is known to 10°, rad from +x towards +y.
    """
    if len(points) < 4:
        return None
    middle = np.median(points, axis=0)
    readings = [
        reading
        for guess in guesses(points, middle, towards)
        for reading in _read(points - middle, guess)
    ]
    if not readings:
        return None
    readings.sort(key=lambda r: -r.score)
    best = _settled(points - middle, readings[0])
    return _found(points, middle, best, readings[1:])


def _read(points: Points, guess: Guess) -> list[_Reading]:
    c, s = math.cos(guess.direction), math.sin(guess.direction)
    u, v = points @ np.array([c, s]), points @ np.array([-s, c])
    curve = common_curve(u, v, guess)
    return [_Reading(guess, rows, u, curve) for rows in fits(u, v - curve, guess.spacing)]


def _settled(points: Points, reading: _Reading) -> _Reading:
    """Read once more along the direction that the rows found have on average."""
    spread = np.zeros((2, 2))
    for k in range(len(reading.rows.levels)):
        row = points[reading.rows.member == k]
        spread += np.cov(row.T, bias=True) * len(row)
    _, axes = np.linalg.eigh(spread)
    direction = math.atan2(axes[1, 1], axes[0, 1]) % math.pi
    old = reading.guess
    turned = Guess(direction, old.bend, old.spacing, old.strength)
    return max([reading, *_read(points, turned)], key=lambda r: r.score)


def _found(points: Points, middle: Points, best: _Reading, others: list[_Reading]) -> FoundRows:
    rows, direction = best.rows, best.guess.direction
    order = [np.flatnonzero(rows.member == k) for k in range(len(rows.levels))]
    order = [row[np.argsort(best.u[row])] for row in order]
    c, s = math.cos(direction), math.sin(direction)
    across = best.curve + rows.across
    on_rows = middle + best.u[:, None] * np.array([c, s]) + across[:, None] * np.array([-s, c])
    spacing = float(np.median(np.diff(rows.levels))) if len(order) > 1 else 0.0
    apart = np.flatnonzero(rows.member < 0)
    return FoundRows(
        direction=direction,
        rows=tuple(order),
        apart=apart,
        on_rows=on_rows,
        spacing=spacing,
        scatter=rows.scatter,
        doubt=rows.doubt,
        why_not=tuple(_doubts(len(points), best, others, spacing, len(apart))),
    )


def _doubts(
    n: int, best: _Reading, others: list[_Reading], spacing: float, apart: int
) -> list[str]:
    why = []
    rows = best.rows
    if rows.doubt > _WRONG:
        why.append(
            f"rows {spacing:.1f} m apart and positions that scatter by {rows.scatter:.1f} m: "
            f"about {rows.doubt:.0%} of the trees would be in a wrong row"
        )
    if rows.scatter > _SCATTER_MOST or 0 < spacing < _SPACING_LEAST * rows.scatter:
        why.append(
            f"the trees scatter by {rows.scatter:.1f} m about rows {spacing:.1f} m apart: "
            "these may be several rows taken as one"
        )
    if apart > _APART * n:
        why.append(f"{apart} of {n} trees stand in no row")
    rival = next((o for o in others if _differ(o, best) and o.score > best.score - _RIVAL), None)
    if rival is not None:
        why.append(
            f"{len(rows.levels)} rows one way and {len(rival.rows.levels)} rows at "
            f"{_between(rival, best):.0f}° to it fit alike"
        )
    return why


def _between(a: _Reading, b: _Reading) -> float:
    off = (a.guess.direction - b.guess.direction + math.pi / 2) % math.pi - math.pi / 2
    return abs(math.degrees(off))


def _differ(a: _Reading, b: _Reading) -> bool:
    """Whether they are other rows, not the same rows with a few trees given to a neighbour."""
    if len(a.rows.levels) != len(b.rows.levels):
        return True
    ours, theirs = a.rows.member, b.rows.member
    turned = np.where(theirs >= 0, len(b.rows.levels) - 1 - theirs, -1)
    same = max(float((ours == theirs).mean()), float((ours == turned).mean()))
    return same < 1 - _SAME
