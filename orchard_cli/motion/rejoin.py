"""Where behind an obstacle to be back on the reference."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchard_cli.mapping import DistanceField
from orchard_cli.model.arrays import Array, Points, Vector

from . import _kernels
from .checks import frame_of

LEADS = (3.0, 2.0, 1.2, 0.0)
"""m of free reference before the rejoin point that do where the lead asked for is not to be had;
0 is as much as there is."""

_LEAST = 0.3  # m of free reference, at least
_FROM_END = 1.0  # m that are enough to come to rest at the reference's end
_CORNER = 0.35  # rad: a stretch that turns by more leads round a corner of the route


@dataclass(frozen=True, slots=True)
class Rejoin:
    """A knot of the reference, and the free reference before it."""

    knot: int  # counted from the first one given
    room: float  # m
    skips_corner: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """The reference ahead, and where it is free."""

    knots: Points  # (n, 3) m
    lengths: Array  # (n,) m along it
    free: NDArray[np.bool_]  # (n,)
    behind: Array  # (n,) m of free reference before each knot, counted from the conflict on
    before: Array  # (n,) m after it
    turned: Array  # (n,) rad between the conflict and each knot
    ends: bool  # whether the last knot is the reference's end

    @classmethod
    def of(
        cls, knots: Points, conflict: Vector, field: DistanceField, floor: float, ends: bool
    ) -> Stretch:
        """Look along the reference's `knots` (n, 3) m.

        `conflict` (2,) m: the first place that is blocked, nothing before it counts; `floor` m:
        what the field must show where the reference is free.
        """
        beside = int(np.argmin(np.hypot(knots[:, 0] - conflict[0], knots[:, 1] - conflict[1])))
        out = np.empty((len(knots), 5))
        _kernels.free_again(knots, beside, field.values, frame_of(field), floor, out)
        return cls(knots, out[:, 0], out[:, 1] > 0, out[:, 2], out[:, 3], out[:, 4], ends)


def choose_rejoin(stretch: Stretch, lead: float, ahead: float) -> Rejoin | None:
    """The first knot with `lead` m of free reference behind it and `ahead` m before it.

    A corner of the route is not skipped: a shorter lead is taken instead (LEADS), and only when
    none fits on the obstacle's own leg the first knot anywhere.
    """
    same = stretch.turned <= _CORNER
    for allowed in (same, np.ones_like(same)):
        for wanted in (lead, *(shorter for shorter in LEADS if shorter < lead)):
            knot = _first(stretch, allowed, wanted, ahead)
            if knot is not None:
                return Rejoin(knot, float(stretch.behind[knot]), bool(~same[knot]))
    return None


def _first(stretch: Stretch, allowed: NDArray[np.bool_], lead: float, ahead: float) -> int | None:
    behind, room = stretch.behind, stretch.before >= ahead
    if lead == 0:
        most = np.where(allowed & room, behind, 0.0)
        good = (most == most.max()) & (most > _LEAST)
    else:
        good = (behind >= lead) & room & allowed
    if stretch.ends:
        good[-1] |= bool(behind[-1] >= min(max(lead, _LEAST), _FROM_END) and allowed[-1])
    knot = int(good.argmax())
    return knot if good[knot] else None


def path_lengths(points: Points) -> Array:
    """Horizontal path length from the first of the points (n, 3) to each (n,), m."""
    steps = np.hypot(*np.diff(points[:, :2], axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])
