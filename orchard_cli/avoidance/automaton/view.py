"""Radar and laser scans as what the automaton reads: the obstacle ahead, and where it is."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from orchard_cli.geometry.rotations import rotate
from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.sensors import RadarScan, RangeScan
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import VehicleState
from orchard_cli.motion.situation import Situation

from .reflections import Reflections, agreeing
from .states import NOTHING, Reading

BAND = 0.5  # m over and under the vehicle in which an obstacle stands in its way, and
BAND_GROWTH = 0.02  # m more of it for each metre of range: what the radar's elevation is worth
KEPT = 0.35  # s for which the obstacle is remembered when the radar loses it
STALE = 0.5  # s: older scans say nothing
CONE = math.cos(math.radians(45.0))  # what is ahead lies within so much of where the path sets out
JOINED = 0.8  # m between reflections of one thing
REACH = 30.0  # m
FRESH = 0.5  # s: reflections that say where a thing's edge is


@dataclass(slots=True, eq=False)
class View:
    """Remembers the last scans: a reflection counts when one of the two scans before has it too,
    and a laser is free when it measures nothing twice."""

    _radar: list[tuple[float, Points]] = field(default_factory=list)  # time, (n, 3) m, site
    _range: list[RangeScan] = field(default_factory=list)
    _confirmed: Points = field(default_factory=lambda: np.empty((0, 3)))  # of the newest scan
    _fresh: list[tuple[float, Points]] = field(default_factory=list)  # time, confirmed, at height
    _known: Reflections = field(default_factory=Reflections)
    _aside: tuple[float, float] = (-math.inf, math.nan)  # time, m

    def look(self, situation: Situation) -> None:
        """Take the scans that are new."""
        radar, lasers = situation.sensed.radar, situation.sensed.range
        if radar is not None and (not self._radar or radar.time > self._radar[-1][0]):
            points = _points_site(radar, situation.vehicle)
            older = [p for _, p in self._radar[-2:]]
            self._radar = [*self._radar[-2:], (radar.time, points)]
            known = np.concatenate([np.empty((0, 3)), *older])
            self._confirmed = _at_height(
                points[agreeing(points, known, situation.vehicle.position_site)], situation.vehicle
            )
            self._fresh = [one for one in self._fresh if radar.time - one[0] < FRESH]
            self._fresh.append((radar.time, self._confirmed))
            self._known.take(self._confirmed, radar, situation.vehicle)
        if lasers is not None and (not self._range or lasers.time > self._range[-1].time):
            self._range = [*self._range[-1:], lasers]

    def age(self, now: float) -> float:
        """s since the older of the two sensors' newest scans; inf when one has never spoken."""
        if not self._radar or not self._range:
            return math.inf
        return now - min(self._radar[-1][0], self._range[-1].time)

    def reading(
        self, situation: Situation, width: float, facing: Vector, thing: Vector | None
    ) -> Reading:
        """`width`: m beside the path ahead in which things count; `facing` (2,): forward; `thing`
        (3,) m: a reflection of what is being avoided, of which d_b is then."""
        here = situation.vehicle.position_site
        there = self._confirmed if thing is None else _of_one_thing(self._confirmed, thing)
        onward = None if thing is None else facing
        ahead, aside = self._ahead(situation, width, onward), math.nan
        if len(there):
            away = there[:, :2] - here[:2]
            nearest = away[int(np.argmin(np.linalg.norm(away, axis=1)))]
            aside = float(facing[0] * nearest[1] - facing[1] * nearest[0])
            self._aside = (situation.now, aside)
        elif situation.now - self._aside[0] < KEPT:
            aside = self._aside[1]
        return Reading(ahead, aside, self._lasers())

    def obstacle(
        self, situation: Situation, width: float, onward: Vector | None = None, sure: bool = False
    ) -> Vector | None:
        """(3,) m: the nearest reflection in the way, of those that are remembered.

        `onward` (2,): the way that is flown on when the active trajectory ends. `sure`: not what
        is in the way only by the radar's error.
        """
        path = _path_ahead(situation, onward)
        there = self._known.points
        forward = (there[:, :2] - path[0]) @ _direction(path) >= 0.0
        gaps = _distances(there[:, :2], path)[0] + (self._known.errors if sure else 0.0)
        there = there[forward & (gaps < width)]
        if not len(there):
            return None
        away = np.linalg.norm((there - situation.vehicle.position_site)[:, :2], axis=1)
        return np.asarray(there[int(np.argmin(away))])

    def near(self, trajectory: Trajectory, begin: float, length: float) -> float:
        """m between what is remembered and the first `length` m of a trajectory from `begin` s on;
        inf: nothing is."""
        path = trajectory.sample(np.linspace(begin, trajectory.end, 400))[0][:, :2]
        flown = np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))
        path = path[: max(int(np.searchsorted(flown, length)) + 2, 2)]
        gaps, _ = _distances(self._known.points[:, :2], path)
        return float(gaps.min(initial=math.inf))

    def edge(self, thing: Vector, here: Vector, aside: Vector) -> float:
        """m from `here` (3,) to the thing's edge, towards `aside` (2,) unit; inf: nothing is known.

        `thing` (3,) m is one of its reflections.
        """
        fresh = np.concatenate([np.empty((0, 3)), *(points for _, points in self._fresh)])
        points = _of_one_thing(fresh if len(fresh) else self._known.points, thing)
        return float(((points - here)[:, :2] @ aside).min()) if len(points) else math.inf

    def _ahead(self, situation: Situation, width: float, onward: Vector | None) -> float:
        """m to the nearest remembered reflection in the way and ahead: along the path where it
        bends, straight where it does not."""
        path, there = _path_ahead(situation, onward), self._known.points
        away = there[:, :2] - path[0]
        straight = np.linalg.norm(away, axis=1)
        direction = _direction(path)
        direction = direction / max(float(np.linalg.norm(direction)), 1e-9)
        gaps, along = _distances(there[:, :2], path)
        counts = (away @ direction >= CONE * straight) & (gaps < width)
        return float(np.maximum(straight, along)[counts].min(initial=math.inf))

    def _lasers(self) -> tuple[float, float, float, float]:
        if not self._range:
            return (NOTHING,) * 4
        ranges = np.min([scan.ranges for scan in self._range], axis=0)
        a, b, c, d = (float(one) for one in ranges)
        return (a, b, c, d)


def _points_site(scan: RadarScan, vehicle: VehicleState) -> Points:
    """(n, 3) m, from where the vehicle was when it was scanned."""
    there = vehicle.position_site - vehicle.velocity_site * (vehicle.time - scan.time)
    return np.asarray(rotate(vehicle.site_from_body, scan.points_body) + there)


def _at_height(points: Points, vehicle: VehicleState) -> Points:
    """Those of the points (n, 3) that stand at the vehicle's own height."""
    off = points - vehicle.position_site
    band = BAND + BAND_GROWTH * np.linalg.norm(off, axis=1)
    standing: Points = points[np.abs(off[:, 2]) < band]
    return standing


def _near(points: Points, known: Points) -> Array:
    """Which of the points (n, 3) have a known one (k, 3) beside them."""
    if not len(points) or not len(known):
        return np.zeros(len(points), dtype=np.bool_)
    off = np.linalg.norm(points[:, None, :2] - known[None, :, :2], axis=2)
    return np.asarray((off < JOINED).any(axis=1))


def _path_ahead(situation: Situation, onward: Vector | None) -> Points:
    """(k, 2) m: what is flown next, and, in a manoeuvre, straight on from its end."""
    active = situation.active
    horizon = 30.0 / max(situation.limits.speed, 0.1)
    end = max(min(active.end, situation.now + horizon), situation.now + 0.1)
    places: Points = active.sample(np.linspace(situation.now, end, 80))[0][:, :2]
    return places if onward is None else np.vstack([places, places[-1] + REACH * onward])


def _direction(path: Points) -> Vector:
    """(2,) which way a path (k, 2) sets out; zero when it stays where it is."""
    off = path - path[0]
    gone = np.flatnonzero(np.linalg.norm(off, axis=1) > 0.05)
    return np.asarray(off[gone[0]] if len(gone) else np.zeros(2))


def _distances(points: Points, path: Points) -> tuple[Array, Array]:
    """m from each point (n, 2) to a polyline (k, 2), and along it to where they are nearest."""
    a, b = path[:-1], path[1:]
    along = b - a
    square = np.maximum((along**2).sum(axis=1), 1e-12)
    offset = points[:, None] - a[None]
    share = np.clip((offset * along).sum(axis=2) / square, 0.0, 1.0)
    gaps = np.linalg.norm(offset - share[..., None] * along, axis=2)
    lengths = np.sqrt(square)
    flown = np.concatenate([[0.0], np.cumsum(lengths)[:-1]]) + share * lengths
    nearest = gaps.argmin(axis=1)[:, None]
    return (
        np.take_along_axis(gaps, nearest, axis=1)[:, 0],
        np.take_along_axis(flown, nearest, axis=1)[:, 0],
    )


def _of_one_thing(points: Points, thing: Vector) -> Points:
    """Those of the points (n, 3) that hang together with `thing` (3,)."""
    found = np.linalg.norm((points - thing)[:, :2], axis=1) < JOINED
    while True:
        more = _near(points, points[found]) | found
        if more.sum() == found.sum():
            joined: Points = points[found]
            return joined
        found = more
