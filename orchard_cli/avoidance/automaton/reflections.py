"""What the radar has found stands until the radar looks there again and finds nothing."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from orchard_cli.geometry.rotations import matrix
from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.sensors import RadarScan
from orchard_cli.model.vehicle import VehicleState

SAME = 0.25  # m between reflections that are one
AGREE, AGREE_SHARE = 0.25, 0.03  # m, and of the range: two that differ by less are of one thing
NEARER = 0.8  # of the range it was measured from: from there it is measured anew
SURE_OF = 3  # scans that have it, before anything is done about it: a ghost does not come thrice
FLEETING = 0.4  # s after which what had fewer is forgotten
SURE = 0.7  # of the radar's field of view, in which it would see what stands there
NEAREST = 0.8  # m: nearer it may not
LOOKS = 20  # at a place without finding anything there, after which nothing stands there: 2 s
LONGEST = 60.0  # s for which anything is remembered that is not looked at
MOST = 500


@dataclass(slots=True, eq=False)
class Reflections:
    """Confirmed reflections in the site frame.

    A radar of 50 by 20 degrees loses what it passes, and what stands ahead when the vehicle tilts
    to speed up or to brake. That is not a reason to take the way for free.
    """

    _points: Points = field(default_factory=lambda: np.empty((0, 3)))  # (n, 3) m
    _range: Array = field(default_factory=lambda: np.empty(0))  # (n,) m it was measured from
    _hits: Array = field(default_factory=lambda: np.empty(0))  # (n,) scans that had it
    _seen: Array = field(default_factory=lambda: np.empty(0))  # (n,) s, last
    _missed: Array = field(default_factory=lambda: np.empty(0))  # (n,) looks since then

    @property
    def points(self) -> Points:
        """(k, 3) m: those that are sure."""
        sure: Points = self._points[self._hits >= SURE_OF]
        return sure

    @property
    def errors(self) -> Array:
        """(k,) m by which those may be off: the farther they were measured from, the more."""
        return np.asarray(AGREE_SHARE * self._range[self._hits >= SURE_OF])

    def take(self, confirmed: Points, scan: RadarScan, vehicle: VehicleState) -> None:
        """A scan, and its confirmed reflections (k, 3) m at the vehicle's height."""
        here, now = vehicle.position_site, scan.time
        again = agreeing(self._points, confirmed, here)
        self._seen[again], self._missed[again] = now, 0
        self._hits[again] += 1
        self._missed[self._in_sight(scan, vehicle) & ~again] += 1
        stale = again & (_away(self._points, here) < NEARER * self._range)
        sure = agreeing(confirmed, self._points[stale & (self._hits >= SURE_OF)], here)
        self._keep(~stale)
        new = ~_within(confirmed, self._points, SAME)
        count = int(new.sum())
        self._points = np.concatenate([self._points, confirmed[new]])
        self._range = np.concatenate([self._range, _away(confirmed[new], here)])
        self._hits = np.concatenate([self._hits, np.where(sure[new], SURE_OF, SURE_OF - 1)])
        self._seen = np.concatenate([self._seen, np.full(count, now)])
        self._missed = np.concatenate([self._missed, np.zeros(count)])
        lasting = np.where(self._hits >= SURE_OF, LONGEST, FLEETING)
        self._keep((self._missed < LOOKS) & (now - self._seen < lasting))

    def _keep(self, stands: NDArray[np.bool_]) -> None:
        rows = np.flatnonzero(stands)[-MOST:]
        self._points, self._range = self._points[rows], self._range[rows]
        self._hits = self._hits[rows]
        self._seen, self._missed = self._seen[rows], self._missed[rows]

    def _in_sight(self, scan: RadarScan, vehicle: VehicleState) -> NDArray[np.bool_]:
        """Which points (n,) the radar would see."""
        radar = scan.radar
        body = (self._points - vehicle.position_site) @ matrix(vehicle.site_from_body)
        x, y, z = ((body - radar.position_body) @ radar.body_from_radar).T
        flat = np.hypot(x, y)
        aside, up = np.abs(np.arctan2(y, x)), np.abs(np.arctan2(z, flat))
        inside = (aside < SURE * radar.width / 2) & (up < SURE * radar.height / 2)
        return np.asarray(inside & (flat > NEAREST) & (flat < SURE * radar.range_max))


def agreeing(points: Points, others: Points, here: Vector) -> NDArray[np.bool_]:
    """(n,) whether a point (n, 3) has one of the others (k, 3) as near as the radar measures from
    `here` (3,): a cell of 2.5 degrees is the wider, the farther it is."""
    return _within(points, others, AGREE + AGREE_SHARE * _away(points, here))


def _away(points: Points, here: Vector) -> Array:
    """(n,) m from above."""
    return np.asarray(np.linalg.norm((points - here)[:, :2], axis=1))


def _within(points: Points, others: Points, distance: Array | float) -> NDArray[np.bool_]:
    """(n,) whether a point (n, 3) has one of the others (k, 3) as near, seen from above."""
    if not len(points) or not len(others):
        return np.zeros(len(points), dtype=np.bool_)
    off = np.linalg.norm(points[:, None, :2] - others[None, :, :2], axis=2)
    return np.asarray(off.min(axis=1) < distance)
