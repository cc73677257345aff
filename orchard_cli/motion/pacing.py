"""Where along a path to be at each knot: the sampling of the guide path."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Array, Points

_STATIONS = 48
_CRAWL = 0.05  # m/s, so that a stretch from rest takes a finite time


def pace(
    guide: Points,
    reference: Points,
    interval: float,
    speeds: tuple[float, float],
    cruise: float,
    acceleration: float,
) -> Points:
    """Points (n + 1, 2) along a path, n whole intervals apart in time, its ends included.

    The paper samples the guide path evenly (Liu 2024, §4.3). So does this where the reference is
    flown at constant speed; where the reference slows (at a corner), or the span begins or ends
    at another speed, the points lie as far apart as the vehicle can fly.

    `guide` (m, 2) m; `reference` (k, 3): control points of the stretch that the guide replaces,
    for its speeds; `speeds`: at the ends, m/s; `cruise`: share of the reference's speed to fly.
    """
    lengths = _lengths(guide)
    total = float(lengths[-1])
    s = np.linspace(0.0, total, _STATIONS)
    own = _lengths(reference)
    spacing = np.gradient(own) / interval
    wanted = cruise * np.interp(s / max(total, 1e-9), own / max(float(own[-1]), 1e-9), spacing)
    slack = 2 * acceleration * s
    rest = slack[::-1]
    first, last = speeds[0] ** 2, speeds[1] ** 2
    fastest = np.sqrt(np.minimum(first + slack, last + rest))
    slowest = np.sqrt(np.maximum(np.maximum(first - slack, last - rest), 0.0))
    speed = np.maximum(np.minimum(np.maximum(wanted, slowest), fastest), _CRAWL)
    steps = 2 * np.diff(s) / (speed[1:] + speed[:-1])
    times = np.concatenate([[0.0], np.cumsum(steps)])
    n = max(int(np.ceil(times[-1] / interval - 0.05)), 2)
    at = _where(np.linspace(0.0, times[-1], n + 1), times, s, speed)
    return np.column_stack([np.interp(at, lengths, guide[:, c]) for c in range(2)])


def _where(at: Array, times: Array, s: Array, speed: Array) -> Array:
    """Path length at the times `at`, the acceleration constant between stations."""
    i = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    since, lasts = at - times[i], np.diff(times)[i]
    change = np.diff(speed)[i] / lasts
    along: Array = s[i] + since * (speed[i] + change * since / 2)
    return along


def _lengths(points: Points) -> Array:
    steps = np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])
