"""From the search's turning points to a trajectory that is flown, checked before it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.arrays import Points, Vector
from orchard_cli.model.mission import Limits
from orchard_cli.motion.bends import BendLaw
from orchard_cli.motion.course import WIDE, Course, course, rejoin_at
from orchard_cli.motion.rejoin import path_lengths
from orchard_cli.motion.room import first_met, samples
from orchard_cli.motion.splice import knots_of
from orchard_cli.motion.view import View

from .room import Room
from .search import NoWay, Searcher
from .settings import AstarSettings, Attempt

_SPARE = 0.08  # m: the middle of the cell that a place lies in may be nearer
_HALF_BEND = 0.3  # of its radius: the way from its beginning to the corner, at 33°


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """The reference ahead, from the knot beside the head's last."""

    knots: Points  # (n, 3) m
    lengths: NDArray[np.float64]  # (n,) m
    apart: NDArray[np.float64]  # (n,) m to the nearest obstacle

    @classmethod
    def of(cls, view: View, room: Room, window: float) -> Stretch:
        """As far as `window` m."""
        control = view.situation.reference.control_points_site[view.first : view.first + 200]
        knots = knots_of(control)
        lengths = path_lengths(knots)
        n = max(int(np.searchsorted(lengths, window)), 2)
        return cls(knots[:n], lengths[:n], room.at(knots[:n]))

    def free_again(self, margin: float, begin: float, ahead: float) -> float | None:
        """m along to where it is free again, `ahead` m of it, behind what blocks it after `begin` m
        (from there on, when nothing does)."""
        free = self.apart >= margin + _SPARE
        before = np.minimum.accumulate(np.where(free, np.inf, self.lengths)[::-1])[::-1]
        blocked = np.flatnonzero(~free & (self.lengths >= begin))
        after = self.lengths[blocked[0]] if len(blocked) else begin
        good = np.flatnonzero(free & (self.lengths >= after) & (before - self.lengths >= ahead))
        return float(self.lengths[good[0]]) if len(good) else None

    def at(self, length: float) -> Vector:
        """(3,) m."""
        return np.array([np.interp(length, self.lengths, axis) for axis in self.knots.T])

    def heights(self, places: Points) -> NDArray[np.float64]:
        """(n,) m: the reference's height beside places (n, 2)."""
        apart = np.linalg.norm(places[:, None] - self.knots[None, :, :2], axis=2)
        found: NDArray[np.float64] = self.knots[apart.argmin(axis=1), 2]
        return found

    def beside(self, places: Points) -> float:
        """m of the farthest of places (n, 2 or more) from it."""
        apart = np.linalg.norm(places[:, None, :2] - self.knots[None, :, :2], axis=2)
        return float(apart.min(axis=1).max())


def legs_round(
    view: View, room: Room, searcher: Searcher, how: Attempt, floor: float, s: AstarSettings
) -> Course | str:
    """Search from the end of what is committed to where the reference is free again, and fly the
    legs between the key turning points; or why that does not do.

    `floor` m: what must stay between the vehicle's centre and an obstacle in the room.
    """
    limits = view.situation.limits
    stretch = Stretch.of(view, room, s.window)
    straight = _straight(_speed(view), 1.0, limits)
    start = _onwards(view, straight)
    margin = floor + s.accept + how.cut
    begin = float(np.hypot(*(start - stretch.knots[0])[:2]))
    back = stretch.free_again(margin, begin, how.lead + s.ahead)
    if back is None:
        return "the route is not free again within the local map"
    goal = stretch.at(back + how.lead)
    way = searcher.search(room.blocked(margin, start), room.index(start), room.index(goal))
    if isinstance(way, NoWay):
        return f"no way through the map ({way.expanded} cells searched)"
    corners = _corners(room.centres(way.cells[1:-1]), start, goal, stretch)
    if stretch.beside(corners) > s.furthest:
        return f"leads {stretch.beside(corners):.1f} m away from the route"
    cuts = np.concatenate([[WIDE], np.full(len(corners) - 2, how.cut), [WIDE]])
    after = _straight(limits.speed, how.cruise, limits)
    rejoin = rejoin_at(view.situation.reference, view.first, goal, after)
    found = course(
        view.head, corners, view.situation.reference, view.first, rejoin, how.cruise, limits,
        cuts, slow_in_bends=True,
    )  # fmt: skip
    if isinstance(found, str):
        return found
    return _checked(view, room, found, floor, how, s)


def _checked(
    view: View, room: Room, found: Course, floor: float, how: Attempt, s: AstarSettings
) -> Course | str:
    limits = view.situation.limits
    until = found.rejoin + s.ahead / limits.speed
    places = samples(found.trajectory, view.head.begin, until)
    met = first_met(places, room.at(places), floor + s.accept)
    if met.blocked_at is not None:
        return f"comes within {met.clearance:.2f} m of an obstacle"
    speed = how.cruise * limits.speed
    if view.stopped and not view.sight.looks_ahead(found.trajectory, view.head.begin, speed):
        return "the camera has not looked where it leads"
    return found


def _speed(view: View) -> float:
    """m/s at the end of the head."""
    points = view.head.control_points_site
    return float(np.linalg.norm(points[-1] - points[-2])) / view.head.interval


def _straight(speed: float, cruise: float, limits: Limits) -> float:
    """m from a place passed at `speed` m/s to the corner next to it: half of a bend there, and the
    way to change to the cruise speed."""
    law = BendLaw.of(limits, cruise * limits.speed)
    changed = max(speed**2 - law.speed**2, 0.0) / (2 * law.along)
    return _HALF_BEND * speed**2 / law.across + changed


def _onwards(view: View, length: float) -> Vector:
    """(3,) m: straight on from the head, so that the first leg begins in its direction; where it
    stands still, right there."""
    points = view.head.control_points_site
    way = points[-1] - points[-2]
    size = float(np.hypot(*way[:2]))
    if size < 1e-6:
        return np.asarray(points[-1])
    return np.asarray(points[-1] + way * (length / size) * np.array([1.0, 1.0, 0.0]))


def _corners(turns: Points, start: Vector, goal: Vector, stretch: Stretch) -> Points:
    """Start, turning points (n, d) and goal; in two dimensions they keep the route's height."""
    if turns.shape[1] == 2:
        turns = np.column_stack([turns, stretch.heights(turns)])
    return np.vstack([start, turns, goal])
