"""Where a call stands: what is kept of the active trajectory, and the path ahead."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.model.trajectory import DEGREE

from .path import Path
from .sight import Sight
from .situation import Situation
from .splice import (
    Head,
    counterpart,
    head_at,
    knots_of,
    nearest_knot,
    shared_tail,
)

_SEARCHED = 40  # knots ahead among which a stopped vehicle looks for its place on the reference


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """What one call works on."""

    situation: Situation
    head: Head
    stopped: bool  # the active trajectory ends before the reference does
    first: int  # the reference's knot beside the head's last
    ahead: Path  # what is to be flown: the active trajectory, or the reference while stopped

    @classmethod
    def of(cls, situation: Situation, progress: int, length: float) -> View:
        """Look `length` m ahead. `progress`: the reference's knot reached when last on it."""
        reference, active = situation.reference, situation.active
        head = head_at(active, situation.commit, reference.interval)
        tail = shared_tail(active, reference)
        here = knots_of(head.control_points_site[-DEGREE:])[0]
        speed = situation.limits.speed
        if tail < DEGREE:
            first = nearest_knot(reference, here, progress, progress + _SEARCHED)
            begin = reference.start + first * reference.interval
            rest = Path.of(reference, begin, length, speed).points_site
            return cls(situation, head, True, first, Path.through(np.vstack([here, rest[1:]])))
        knot = len(head.control_points_site) - DEGREE
        first = counterpart(active, reference, tail, knot, here)
        ahead = Path.of(active, situation.now, length, speed)
        return cls(situation, head, False, first, ahead)

    @property
    def begin(self) -> float:
        """m along the path ahead to where a change may begin."""
        if self.stopped:
            return 0.0
        return self.ahead.beside(self.head.control_points_site[-1])[0]

    @property
    def sight(self) -> Sight:
        """What the camera has looked at."""
        return Sight(self.situation)
