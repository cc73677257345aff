"""Where a call stands: what is kept of the active trajectory, and the path ahead."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.arrays import Points
from orchard_cli.model.trajectory import DEGREE, Trajectory

from .path import Path
from .situation import Situation
from .splice import (
    Head,
    counterpart,
    head_at,
    knots_of,
    nearest_knot,
    shared_tail,
)

Flags = NDArray[np.bool_]

_SEARCHED = 40  # knots ahead among which a stopped vehicle looks for its place on the reference
_GAP = 0.5  # m not looked at between what was, that do not count
_STEP = 0.1  # s


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

    def looked(self, trajectory: Trajectory, begin: float, end: float) -> float:
        """m of trajectory from time `begin` to the first place that nobody has looked at; inf when
        all was looked at until `end`.

        Looked at is what the map has observed, and what lies in the camera's view now, seen from
        above: rays that end in the sky clear nothing in the map.
        """
        times = np.arange(begin, min(end, trajectory.end), _STEP)
        if len(times) < 2:
            return np.inf
        places = trajectory.sample(times)[0]
        lengths = np.concatenate(
            [[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))]
        )
        seen = self._in_view(places) | self._mapped(places)
        last = np.maximum.accumulate(np.where(seen, lengths, 0.0))
        lost = np.flatnonzero(lengths - last >= _GAP)
        return float(last[lost[0]]) if len(lost) else np.inf

    def looks_ahead(self, trajectory: Trajectory, begin: float, speed: float) -> bool:
        """Whether all that full braking from `speed` m/s would cross has been looked at."""
        needed = speed**2 / (2 * self.situation.limits.acceleration) + speed * trajectory.interval
        return self.looked(trajectory, begin, begin + 2 * needed / max(speed, 0.1)) >= needed

    def _in_view(self, places: Points) -> Flags:
        vehicle, camera = self.situation.vehicle, self.situation.frame.camera
        nose = np.array([np.cos(vehicle.yaw_site), np.sin(vehicle.yaw_site)])
        away = places[:, :2] - vehicle.position_site[:2]
        depth, side = away @ nose, np.abs(away @ np.array([-nose[1], nose[0]]))
        seen: Flags = (depth < camera.range_max) & (side <= depth * camera.width / (2 * camera.fx))
        return seen

    def _mapped(self, places: Points) -> Flags:
        low, high = places.min(axis=0), places.max(axis=0)
        middle, half = (low + high)[:2] / 2, float(np.max(high - low)) / 2 + 1.0
        band = self.situation.grid.band(middle, half, float(low[2]) - 0.3, float(high[2]) + 0.3)
        cells = np.floor((places[:, :2] - band.origin_site) / band.cell).astype(np.int64)
        cells = np.clip(cells, 0, np.array(band.observed.shape) - 1)
        observed: Flags = band.observed[cells[:, 0], cells[:, 1]]
        return observed
