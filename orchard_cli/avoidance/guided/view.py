"""What one call looks at, all on fine knots."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.mapping import Band, DistanceField, distance_field
from orchard_cli.model.arrays import Points
from orchard_cli.model.trajectory import DEGREE, Trajectory
from orchard_cli.motion.rejoin import path_lengths
from orchard_cli.motion.sight import Sight
from orchard_cli.motion.situation import Situation
from orchard_cli.motion.splice import (
    Head,
    counterpart,
    head_at,
    knots_of,
    nearest_knot,
    shared_tail,
)
from orchard_cli.motion.subdivision import refined

from .settings import GuidedSettings

_BACK = 20.0  # s of reference in which a vehicle that stands beside it is looked for
_BESIDE = 0.2  # m of map beyond the reach of distances around what is only glanced at


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """What is flown and what should be flown."""

    active: Trajectory  # with fine knots, if it can be told so
    reference: Trajectory  # with fine knots
    tail: int  # control points that the active trajectory shares with the reference's end

    @property
    def stopped(self) -> bool:
        """Whether the active trajectory ends before the reference does."""
        return self.tail < DEGREE


@dataclass(frozen=True, slots=True, eq=False)
class Glance:
    """What every call looks at: the map around what is flown next, and no more of it."""

    situation: Situation
    course: Course
    band: Band
    field: DistanceField
    floor: float  # m, least distance in the field: Limits.clearance and half a cell

    @property
    def sight(self) -> Sight:
        """What the camera has looked at."""
        return Sight(self.situation, self.band)


@dataclass(frozen=True, slots=True, eq=False)
class View(Glance):
    """What a call looks at that may answer with another way: the map around that too."""

    head: Head
    first: int  # the reference's knot beside the head's last
    rejoins: Points  # (n, 3) m, the reference's knots from `first` on, within the window

    @property
    def active(self) -> Trajectory:
        """What is flown, with fine knots."""
        return self.course.active

    @property
    def reference(self) -> Trajectory:
        """What should be flown, with fine knots."""
        return self.course.reference

    @property
    def stopped(self) -> bool:
        """Whether the active trajectory ends before the reference does."""
        return self.course.stopped

    @property
    def ends(self) -> bool:
        """Whether the reference ends within the window."""
        return self.first + len(self.rejoins) == len(self.reference.control_points_site) - 2


class Eyes:
    """Makes glances and views. Remembers curves with fine knots, and how far along the reference
    the vehicle is."""

    def __init__(self, settings: GuidedSettings) -> None:
        self._settings = settings
        self._given: tuple[Trajectory, Trajectory] | None = None  # active and reference
        self._course: Course | None = None
        self._progress = 0

    def glance(self, situation: Situation) -> Glance:
        """The map around what is flown next: enough to see that it is free."""
        s, course = self._settings, self._courses(situation.active, situation.reference)
        active, speed = course.active, situation.limits.speed
        self._follow(course, self._head(situation, course))
        braking = speed / situation.limits.acceleration + 2 * active.interval
        until = max(situation.now + s.look_ahead / speed, situation.commit + braking)
        points = active.control_points_site[
            active.segment(situation.now) : active.segment(until) + DEGREE + 1
        ]
        low, high = points.min(axis=0), points.max(axis=0)
        (x, y, _), (across, along, _) = (low + high) / 2, (high - low) / 2 + s.reach + _BESIDE
        band = situation.grid.band(
            np.array([x, y]), (float(across), float(along)), *self._heights(situation, low, high)
        )
        return Glance(
            situation, course, band, distance_field(band, s.reach), _floor(situation, band)
        )

    def look(self, glance: Glance) -> View:
        """Everything that another way is found by."""
        s, situation, course = self._settings, glance.situation, glance.course
        reference, head = course.reference, self._head(situation, course)
        here, first = self._follow(course, head)
        most = round(s.window / reference.interval) * 4
        rejoins = knots_of(reference.control_points_site[first : first + most])
        rejoins = rejoins[: int(np.searchsorted(path_lengths(rejoins), s.window)) + 1]
        low = np.minimum(here, rejoins.min(axis=0))
        high = np.maximum(here, rejoins.max(axis=0))
        band = situation.grid.band(
            (low + high)[:2] / 2, s.half_size, *self._heights(situation, low, high)
        )
        return View(
            situation, course, band, distance_field(band, s.reach), _floor(situation, band),
            head, first, rejoins,
        )  # fmt: skip

    def _courses(self, active: Trajectory, reference: Trajectory) -> Course:
        """Both with fine knots; made anew when either is another one."""
        before, course = self._given, self._course
        if before is None or course is None or before[1] is not reference:
            fine = refined(reference, self._settings.halvings)
            self._progress = 0
        else:
            fine = course.reference
        if (
            course is None
            or before is None
            or before[0] is not active
            or fine is not course.reference
        ):
            told = active
            if active is reference:
                told = fine
            elif abs(active.interval - reference.interval) < 1e-9:
                told = refined(active, self._settings.halvings)
            course = Course(told, fine, shared_tail(told, fine))
        self._given, self._course = (active, reference), course
        return course

    def _head(self, situation: Situation, course: Course) -> Head:
        return head_at(course.active, situation.commit, course.reference.interval)

    def _follow(self, course: Course, head: Head) -> tuple[Points, int]:
        """Where the head ends, (3,) m, and the reference's knot beside it."""
        reference, points = course.reference, head.control_points_site
        here = knots_of(points[-DEGREE:])[0]
        if course.stopped:
            reach = round(_BACK / reference.interval)
            return here, nearest_knot(reference, here, self._progress, self._progress + reach)
        first = counterpart(course.active, reference, course.tail, len(points) - DEGREE, here)
        self._progress = min(first, len(reference.control_points_site) - DEGREE)
        return here, self._progress

    def _heights(self, situation: Situation, low: Points, high: Points) -> tuple[float, float]:
        """From where to where it must be free around a way between two heights, m."""
        below = max(self._settings.below, situation.limits.airframe_radius)
        return float(low[2]) - below, float(high[2]) + self._settings.above


def _floor(situation: Situation, band: Band) -> float:
    return situation.limits.clearance + band.cell / 2
