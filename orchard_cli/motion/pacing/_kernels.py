"""How fast along a path, and where at each knot."""

from __future__ import annotations

import numpy as np
from numba import njit

STATIONS = 64
_CRAWL = 0.05  # m/s, so that a stretch from rest takes a finite time


@njit(cache=True, nogil=True)
def lengths_of(points, out):
    """Horizontal path length from the first of the points (n, 2 or 3) to each (n,), m."""
    out[0] = 0.0
    for i in range(1, points.shape[0]):
        dx, dy = points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1]
        out[i] = out[i - 1] + np.sqrt(dx * dx + dy * dy)


@njit(cache=True, nogil=True)
def pace(guide, reference, spacing, law, out):
    """Places along a path, whole intervals apart in time, its ends included.

    guide (m, 2) m; reference (k, 2 or 3): points `spacing` s apart of the stretch that it
    replaces, for its speeds. law: interval s, first and last speed m/s, cruise as a share of the
    reference's speed, acceleration m/s². Fills `out` (n, 2), as far as it has room; returns n.
    """
    interval, first, last, cruise, acceleration = law
    along, own = np.empty(guide.shape[0]), np.empty(reference.shape[0])
    lengths_of(guide, along)
    lengths_of(reference, own)
    total, whole = along[-1], max(own[-1], 1e-9)
    s, speed, times = np.empty(STATIONS), np.empty(STATIONS), np.empty(STATIONS)
    k, most = 0, reference.shape[0] - 2
    for i in range(STATIONS):
        s[i] = total * i / (STATIONS - 1)
        share = whole * i / (STATIONS - 1)
        while k < most and own[k + 1] < share:
            k += 1
        wanted = cruise * (own[k + 1] - own[k]) / spacing
        slack, rest = 2 * acceleration * s[i], 2 * acceleration * (total - s[i])
        fastest = np.sqrt(min(first * first + slack, last * last + rest))
        slowest = np.sqrt(max(first * first - slack, last * last - rest, 0.0))
        speed[i] = max(min(max(wanted, slowest), fastest), _CRAWL)
    times[0] = 0.0
    for i in range(1, STATIONS):
        times[i] = times[i - 1] + 2 * (s[i] - s[i - 1]) / (speed[i] + speed[i - 1])
    n = max(int(np.ceil(times[-1] / interval - 0.05)), 2) + 1
    if n > out.shape[0]:
        return n
    i, j = 0, 1
    for p in range(n):
        at = times[-1] * p / (n - 1)
        while i < STATIONS - 2 and times[i + 1] <= at:
            i += 1
        since, lasts = at - times[i], times[i + 1] - times[i]
        change = (speed[i + 1] - speed[i]) / max(lasts, 1e-9)
        where = min(s[i] + since * (speed[i] + change * since / 2), total)
        while j < guide.shape[0] - 1 and along[j] < where:
            j += 1
        leg = along[j] - along[j - 1]
        u = min(max((where - along[j - 1]) / leg, 0.0), 1.0) if leg > 0 else 1.0
        for c in range(2):
            out[p, c] = guide[j - 1, c] + u * (guide[j, c] - guide[j - 1, c])
    out[n - 1, 0], out[n - 1, 1] = guide[-1, 0], guide[-1, 1]
    return n
