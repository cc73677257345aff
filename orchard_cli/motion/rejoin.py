"""Where behind an obstacle to be back on the reference."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.arrays import Array, Points, Vector

WIDEST = 0.0  # as a lead: in the middle of the longest free stretch
_LEAST = 0.3  # m of free reference that such a stretch has on both sides
_FROM_END = 1.0  # m that are enough to come to rest at the reference's end


@dataclass(frozen=True, slots=True)
class Rejoin:
    """A knot of the reference, and the free reference before it."""

    knot: int  # counted from the first one given
    room: float  # m


def choose_rejoin(
    knots: Points, free: NDArray[np.bool_], conflict: Vector, lead: float, ahead: float, last: bool
) -> Rejoin | None:
    """The first knot with `lead` m of free reference behind it and `ahead` m before it.

    `knots` (n, 3) m: the reference's; `free` (n,): whether each keeps its distance; `conflict`
    (2,) m: the first place that is blocked, nothing before it counts; `last`: whether the last
    knot is the reference's end. A `lead` of WIDEST takes the middle of the longest free stretch.
    """
    s = path_lengths(knots)
    beside = int(np.argmin(np.linalg.norm(knots[:, :2] - conflict, axis=1)))
    behind = s - np.maximum.accumulate(np.where(free, s[beside], s))
    before = np.minimum.accumulate(np.where(free, np.inf, s)[::-1])[::-1] - s
    if lead == WIDEST:
        room = np.minimum(behind, before)
        good = (room == room.max()) & (room > _LEAST)
    else:
        good = (behind >= lead) & (before >= ahead)
        if last:
            good[-1] |= behind[-1] >= min(lead, _FROM_END)
    found = np.flatnonzero(good)
    return Rejoin(int(found[0]), float(behind[found[0]])) if len(found) else None


def path_lengths(points: Points) -> Array:
    """Horizontal path length from the first of the points (n, 3) to each (n,), m."""
    steps = np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])
