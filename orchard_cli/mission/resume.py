"""What is left to spray: from a place on, or from where a flight stopped."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.arrays import Points, Vector

from .route import Pass

SHORTEST = 0.5  # m: a rest of a line shorter than this is not worth a flight
BESIDE = 1.0  # m beside a line within which a flight with the pump on treats it
_ROW_AND_METRES = re.compile(r"(\d{1,4}):(\d{1,4}(?:\.\d+)?)")
_X_AND_Y = re.compile(r"(-?\d{1,5}(?:\.\d+)?),(-?\d{1,5}(?:\.\d+)?)")
_MEND = "give ROW:METRES from the row's first tree, like 3:12.5, or x,y in metres, like 12.5,6.0"


@dataclass(frozen=True, slots=True)
class Stop:
    """Where a flight stopped spraying."""

    index: int  # of the pass, in flight order
    along: float  # m from where it is entered


@dataclass(frozen=True, slots=True)
class Missed:
    """A stretch before the stop that was not sprayed."""

    row: int  # index into Orchard.rows
    begin_site: tuple[float, float]  # m
    end_site: tuple[float, float]
    length: float  # m


def place(text: str, flown: Sequence[Pass]) -> Stop:
    """The stop that a text names: ROW:METRES, or x,y near a line. Raises InputError."""
    if found := _ROW_AND_METRES.fullmatch(text.strip()):
        return _in_row(int(found[1]), float(found[2]), flown)
    if found := _X_AND_Y.fullmatch(text.strip()):
        return _near(np.array([float(found[1]), float(found[2])]), flown)
    raise InputError(Fault("--resume-at", f"is {text[:40]!r}", _MEND))


def _in_row(row: int, metres: float, flown: Sequence[Pass]) -> Stop:
    """Metres from the side of the row's first tree; of several passes the first one counts."""
    for index, one in enumerate(flown):
        if one.row == row - 1:
            if metres > one.length:
                what = f"row {row} is {one.length:.2f} m long"
                raise InputError(Fault("--resume-at", f"is at {metres:g} m, and {what}", _MEND))
            way = one.points_site[-1, 0] - one.points_site[0, 0]
            return Stop(index, metres if way > 0 else one.length - metres)
    raise InputError(Fault("--resume-at", f"row {row} is not flown", _MEND))


def _near(at: Vector, flown: Sequence[Pass]) -> Stop:
    point = shapely.Point(at)
    lines = np.array([shapely.LineString(one.points_site[:, :2]) for one in flown])
    apart = shapely.distance(lines, point)
    index = int(apart.argmin())
    if apart[index] > BESIDE:
        what = f"is {apart[index]:.1f} m from the nearest line"
        raise InputError(Fault("--resume-at", what, f"give a place within {BESIDE:g} m of one"))
    return Stop(index, float(lines[index].project(point)))


def last_stop(sprayed: Sequence[Sequence[tuple[float, float]]]) -> Stop | None:
    """Where spraying ended: the end of what is sprayed of the last pass with any; None: of none."""
    for index in reversed(range(len(sprayed))):
        if sprayed[index]:
            return Stop(index, sprayed[index][-1][1])
    return None


def rest(flown: Sequence[Pass], stop: Stop) -> list[Pass]:
    """The passes from the stop on, the first one cut exactly there."""
    first, later = flown[stop.index], list(flown[stop.index + 1 :])
    if first.length - stop.along < SHORTEST:
        return later
    return [part(first, stop.along, first.length), *later]


def sprayed_parts(
    flown: Sequence[Pass], lines: Sequence[Points]
) -> list[list[tuple[float, float]]]:
    """For each pass the stretches, (begin, end) m along it, that lines flown with the pump on
    treated; each of those is (n, 2) m in the order of flight.

    A line counts for the pass that it lies at all along and that it was flown in the direction of.
    """
    parts: list[list[tuple[float, float]]] = [[] for _ in flown]
    passes = [shapely.LineString(one.points_site[:, :2]) for one in flown]
    for line in lines:
        points = shapely.points(line)
        apart = np.array([shapely.distance(one, points) for one in passes])
        nearest = apart.argmin(axis=0)
        for index in np.unique(nearest):
            on = (nearest == index) & (apart[index] <= BESIDE)
            along = np.asarray(shapely.line_locate_point(passes[index], points[on]))
            if len(along) > 1 and along[-1] > along[0]:
                parts[index].append((float(along.min()), float(along.max())))
    return [_joined(found) for found in parts]


def _joined(parts: list[tuple[float, float]]) -> list[tuple[float, float]]:
    joined: list[tuple[float, float]] = []
    for begin, end in sorted(parts):
        if joined and begin <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(joined[-1][1], end))
        else:
            joined.append((begin, end))
    return joined


def passed(planned: Sequence[Pass], lines: Sequence[Points]) -> list[Pass]:
    """What a flight that was to spray `planned` has behind it, sprayed or not.

    `lines` are those that it flew with the pump on; it stopped where the last of them ends.
    """
    stop = last_stop(sprayed_parts(planned, lines))
    if stop is None:
        return []
    return [*planned[: stop.index], part(planned[stop.index], 0.0, stop.along)]


def remaining(flown: Sequence[Pass], done: Sequence[Points]) -> list[Pass]:
    """The passes without what lines (n, 2 or 3) m have done, in flight order."""
    parts = sprayed_parts(flown, [line[:, :2] for line in done])
    return [
        part(one, begin, end)
        for one, spans in zip(flown, parts, strict=True)
        for begin, end in _outside(spans, 0.0, one.length)
    ]


def missed(flown: Sequence[Pass], behind: Sequence[Pass], lines: Sequence[Points]) -> list[Missed]:
    """What flights have behind them and did not spray, by the lines with the pump on."""
    sprayed = sprayed_parts(flown, lines)
    over = sprayed_parts(flown, [one.points_site[:, :2] for one in behind])
    found = []
    for one, spans, done in zip(flown, over, sprayed, strict=True):
        for first, last in spans:
            for begin, end in _outside(done, first, last):
                a, *_, b = part(one, begin, end).points_site
                ends = (float(a[0]), float(a[1])), (float(b[0]), float(b[1]))
                found.append(Missed(one.row, *ends, end - begin))
    return found


def _outside(
    spans: Sequence[tuple[float, float]], first: float, last: float
) -> list[tuple[float, float]]:
    """What of [first, last] lies in no span; the spans are in order and apart."""
    edges = [first]
    for begin, end in spans:
        edges += [min(max(begin, first), last), min(max(end, first), last)]
    edges.append(last)
    pairs = zip(edges[::2], edges[1::2], strict=True)
    return [(begin, end) for begin, end in pairs if end - begin >= SHORTEST]


def part(one: Pass, begin: float, end: float) -> Pass:
    """A pass from `begin` to `end`, m along it seen from above."""
    steps = np.hypot(*np.diff(one.points_site[:, :2], axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    inner = (along > begin + 1e-6) & (along < end - 1e-6)
    at = np.concatenate([[begin], along[inner], [min(end, math.nextafter(along[-1], math.inf))]])
    points = np.column_stack([np.interp(at, along, axis) for axis in one.points_site.T])
    return Pass(one.row, points)
