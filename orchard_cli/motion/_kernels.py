"""Looking up a distance field, and walking along a trajectory through it."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def look_up(values, x0, y0, cell, outside, x, y):
    """Bilinear (distance, d/dx, d/dy) of a field whose cell [0, 0] has its corner at (x0, y0)."""
    nx, ny = values.shape
    gx = (x - x0) / cell - 0.5
    gy = (y - y0) / cell - 0.5
    if not (0.0 <= gx < nx - 1 and 0.0 <= gy < ny - 1):
        return outside, 0.0, 0.0
    i, j = int(gx), int(gy)
    fx, fy = gx - i, gy - j
    v00, v01 = values[i, j], values[i, j + 1]
    v10, v11 = values[i + 1, j], values[i + 1, j + 1]
    low = v00 + fx * (v10 - v00)
    high = v01 + fx * (v11 - v01)
    slope_x = ((1.0 - fy) * (v10 - v00) + fy * (v11 - v01)) / cell
    return low + fy * (high - low), slope_x, (high - low) / cell


@njit(cache=True, nogil=True)
def inspect(q, interval, first, last, per_segment, values, frame, floor, slack, found):
    """Walk a trajectory (n, 3) from segment `first` (a float: part segments too) to `last`.

    A place is a conflict when its distance is under `floor`; a walk that begins under it may
    leave, but never come nearer than it was by more than `slack`. `found` receives: path length
    walked to the first conflict (inf: none), its segment (float), least distance, greatest speed,
    acceleration and turning rate of the tangent, and the path length walked.
    """
    found[0], found[1], found[2], found[3:] = np.inf, np.inf, np.inf, 0.0
    steps = int(np.ceil((last - first) * per_segment - 1e-9))
    reached = -np.inf
    px = py = pz = 0.0
    for s in range(steps + 1):
        phase = min(first + s / per_segment, last)
        k = min(max(int(phase), 0), q.shape[0] - 4)
        u = phase - k
        w = 1.0 - u
        b0, b1 = w * w * w / 6, (3 * u * u * u - 6 * u * u + 4) / 6
        b3 = u * u * u / 6
        b2 = 1.0 - b0 - b1 - b3
        d0, d1, d3 = -w * w / 2, (3 * u * u - 4 * u) / 2, u * u / 2
        d2 = -d0 - d1 - d3
        p, v, a = np.empty(3), np.empty(3), np.empty(3)
        for c in range(3):
            q0, q1, q2, q3 = q[k, c], q[k + 1, c], q[k + 2, c], q[k + 3, c]
            p[c] = b0 * q0 + b1 * q1 + b2 * q2 + b3 * q3
            v[c] = (d0 * q0 + d1 * q1 + d2 * q2 + d3 * q3) / interval
            a[c] = (w * (q0 - 2 * q1 + q2) + u * (q1 - 2 * q2 + q3)) / interval**2
        if s > 0:
            found[6] += np.sqrt((p[0] - px) ** 2 + (p[1] - py) ** 2 + (p[2] - pz) ** 2)
        px, py, pz = p[0], p[1], p[2]
        d = look_up(values, frame[0], frame[1], frame[2], frame[3], px, py)[0]
        found[2] = min(found[2], d)
        if found[0] == np.inf and d < (floor if reached >= floor else reached - slack):
            found[0], found[1] = found[6], phase
        reached = max(reached, d)
        speed = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        found[3] = max(found[3], speed)
        found[4] = max(found[4], np.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]))
        flat = v[0] * v[0] + v[1] * v[1]
        if flat > 0.25:  # slower, the nose may lag: the way to a halt is within what it has seen
            found[5] = max(found[5], abs(v[0] * a[1] - v[1] * a[0]) / flat)
