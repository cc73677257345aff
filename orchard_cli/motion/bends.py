"""How fast along a path with bends: as slowly as each bend needs, between two given speeds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.mission import Limits

from .rejoin import path_lengths

STATION = 0.05  # m between places where the speed is decided
WINDOW = 4  # stations on both sides over which a bend is measured: a spline rounds what is shorter
SHARE = 0.65  # of the acceleration limit for bends and for changes of speed, each
_CRAWL = 0.05  # m/s, so that a stretch from rest takes a finite time


@dataclass(frozen=True, slots=True)
class BendLaw:
    """What is allowed on a path."""

    speed: float  # m/s
    across: float  # m/s², towards the inside of a bend
    along: float  # m/s², faster and slower
    yaw_rate: float  # rad/s
    climb_speed: float  # m/s

    @classmethod
    def of(cls, limits: Limits, speed: float) -> BendLaw:
        """With room for both at once: SHARE² + SHARE² is under 1."""
        most = SHARE * limits.acceleration
        return cls(speed, most, most, 0.9 * limits.yaw_rate, 0.9 * limits.climb_speed)


def through_bends(
    guide_site: Points, interval: float, speeds: tuple[float, float], law: BendLaw
) -> Points:
    """Places (n + 1, 2) m along a path (m, 3) m, n whole intervals apart, its ends included.

    `speeds`: at the ends, m/s. Where they leave no other choice (a bend right behind the first) the
    speed falls as fast as `law.along` lets it, and the bend is taken faster than it should be.
    """
    own = path_lengths(guide_site)
    count = max(int(np.ceil(own[-1] / STATION)), 8)
    s = np.linspace(0.0, own[-1], count + 1)
    path = np.column_stack([np.interp(s, own, axis) for axis in guide_site.T])
    first, last = speeds[0] ** 2, speeds[1] ** 2
    cruise = np.maximum(law.speed**2, last - 2 * law.along * (own[-1] - s))
    squared = np.minimum(_fastest(path, s, law) ** 2, cruise)
    squared[0], squared[-1] = first, last
    gain = 2 * law.along * (s[1] - s[0])
    for i in range(count - 1, 0, -1):  # braking, not of the first speed
        squared[i] = min(squared[i], squared[i + 1] + gain)
    for i in range(1, count):  # no faster than can be reached, no slower than can be braked to
        squared[i] = min(squared[i], squared[i - 1] + gain)
        squared[i] = max(squared[i], squared[i - 1] - gain)
    speed = np.maximum(np.sqrt(squared), _CRAWL)
    times = np.concatenate([[0.0], np.cumsum(2 * np.diff(s) / (speed[1:] + speed[:-1]))])
    n = max(int(np.ceil(times[-1] / interval - 0.05)), 2)
    at = _where(np.linspace(0.0, times[-1], n + 1), times, s, speed)
    return np.column_stack([np.interp(at, s, path[:, c]) for c in range(2)])


def _fastest(path: Points, s: Array, law: BendLaw) -> Array:
    """(n,) m/s that the path's shape allows."""
    headings = np.unwrap(np.arctan2(*np.diff(path[:, :2], axis=0).T[::-1]))
    last = len(headings) - 1
    first = np.clip(np.arange(len(s)) - WINDOW, 0, last)
    until = np.clip(np.arange(len(s)) + WINDOW - 1, 0, last)
    turning = np.abs(headings[until] - headings[first])
    bend = np.maximum(turning / ((s[1] - s[0]) * np.maximum(until - first, 1)), 1e-9)
    slope = np.abs(np.gradient(path[:, 2], s))
    allowed: Array = np.minimum.reduce(
        [
            np.sqrt(law.across / bend),
            law.yaw_rate / bend,
            law.climb_speed / np.maximum(slope, 1e-9),
        ]
    )
    return allowed


def _where(at: Array, times: Array, s: Array, speed: Array) -> Array:
    """Path length at the times `at`, the acceleration constant between stations."""
    i = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    since = at - times[i]
    change = np.diff(speed)[i] / np.diff(times)[i]
    along: Array = s[i] + since * (speed[i] + change * since / 2)
    return along
