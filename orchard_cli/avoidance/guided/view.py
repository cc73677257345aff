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


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """What one call looks at."""

    situation: Situation
    active: Trajectory  # with fine knots, if it can be told so
    reference: Trajectory  # with fine knots
    head: Head
    tail: int  # control points that the active trajectory shares with the reference's end
    first: int  # the reference's knot beside the head's last
    rejoins: Points  # (n, 3) m, the reference's knots from `first` on, within the window
    band: Band
    field: DistanceField
    floor: float  # m, least distance in the field: Limits.clearance and half a cell

    @property
    def stopped(self) -> bool:
        """Whether the active trajectory ends before the reference does."""
        return self.tail < DEGREE

    @property
    def ends(self) -> bool:
        """Whether the reference ends within the window."""
        return self.first + len(self.rejoins) == len(self.reference.control_points_site) - 2

    @property
    def sight(self) -> Sight:
        """What the camera has looked at."""
        return Sight(self.situation, self.band)


class Eyes:
    """Makes views. Remembers the reference with fine knots, and how far along it the vehicle is."""

    def __init__(self, settings: GuidedSettings) -> None:
        self._settings = settings
        self._given: Trajectory | None = None
        self._reference: Trajectory | None = None
        self._progress = 0

    def look(self, situation: Situation) -> View:
        """Everything that a call decides by."""
        s = self._settings
        reference, active = self._fine(situation.reference), situation.active
        if active is situation.reference:
            active = reference
        elif abs(active.interval - situation.reference.interval) < 1e-9:
            active = refined(active, s.halvings)
        head = head_at(active, situation.commit, reference.interval)
        tail = shared_tail(active, reference)
        here = knots_of(head.control_points_site[-DEGREE:])[0]
        if tail < DEGREE:
            reach = round(_BACK / reference.interval)
            first = nearest_knot(reference, here, self._progress, self._progress + reach)
        else:
            knot = len(head.control_points_site) - DEGREE
            first = counterpart(active, reference, tail, knot, here)
            first = min(first, len(reference.control_points_site) - DEGREE)
            self._progress = first
        most = round(s.window / reference.interval) * 4
        rejoins = knots_of(reference.control_points_site[first : first + most])
        rejoins = rejoins[: int(np.searchsorted(path_lengths(rejoins), s.window)) + 1]
        band = self._band(situation, here, rejoins)
        return View(
            situation, active, reference, head, tail, first, rejoins, band,
            distance_field(band, s.reach), situation.limits.clearance + band.cell / 2,
        )  # fmt: skip

    def _fine(self, reference: Trajectory) -> Trajectory:
        if self._given is not reference or self._reference is None:
            self._given = reference
            self._reference = refined(reference, self._settings.halvings)
            self._progress = 0
        return self._reference

    def _band(self, situation: Situation, here: Points, rejoins: Points) -> Band:
        s = self._settings
        low = np.minimum(here, rejoins.min(axis=0))
        high = np.maximum(here, rejoins.max(axis=0))
        below = max(s.below, situation.limits.airframe_radius)
        return situation.grid.band(
            (low + high)[:2] / 2, s.half_size, float(low[2]) - below, float(high[2]) + s.above
        )
