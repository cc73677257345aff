"""Inflated obstacle cells, and what meets them.

`grid` (nx, ny, nz) holds the inflated obstacles and `frame` its lower corner and cell, m. Outside
the grid everything is an obstacle.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def inflate(raw, reach, out):
    """Mark the cube of `reach` cells each way around every obstacle cell."""
    nx, ny, nz = raw.shape
    out[:] = False
    tall = np.zeros(nz, dtype=np.bool_)
    for i in range(nx):
        for j in range(ny):
            column = raw[i, j]
            found = False
            for k in range(nz):
                found |= column[k]
            if not found:
                continue
            tall[:] = False
            for k in range(nz):
                if column[k]:
                    tall[max(0, k - reach) : min(nz, k + reach + 1)] = True
            for a in range(max(0, i - reach), min(nx, i + reach + 1)):
                for b in range(max(0, j - reach), min(ny, j + reach + 1)):
                    row = out[a, b]
                    for k in range(nz):
                        row[k] |= tall[k]


@njit(cache=True, nogil=True)
def is_blocked(grid, frame, x, y, z):
    """Whether a place is in an inflated obstacle or outside the grid."""
    i = int(np.floor((x - frame[0]) / frame[3]))
    j = int(np.floor((y - frame[1]) / frame[3]))
    k = int(np.floor((z - frame[2]) / frame[3]))
    if 0 <= i < grid.shape[0] and 0 <= j < grid.shape[1] and 0 <= k < grid.shape[2]:
        return grid[i, j, k]
    return True


@njit(cache=True, nogil=True)
def leg_blocked(grid, frame, a, b):
    """Whether the straight line from a to b (3,) meets an obstacle, looked at twice a cell."""
    length = np.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 + (b[2] - a[2]) ** 2)
    steps = int(np.ceil(2 * length / frame[3])) + 1
    for s in range(steps + 1):
        t = s / steps
        x, y = a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])
        if is_blocked(grid, frame, x, y, a[2] + t * (b[2] - a[2])):
            return True
    return False


@njit(cache=True, nogil=True)
def first_hit(q, first, last, per_segment, grid, frame):
    """Parameter (in segments) of the first blocked place of a B-spline q (n, 3); -1: none."""
    steps = int(np.ceil((last - first) * per_segment - 1e-9))
    for s in range(steps + 1):
        phase = min(first + s / per_segment, last)
        k = min(max(int(phase), 0), q.shape[0] - 4)
        u = phase - k
        w = 1.0 - u
        b0, b3 = w * w * w / 6, u * u * u / 6
        b1 = (3 * u * u * u - 6 * u * u + 4) / 6
        b2 = 1.0 - b0 - b1 - b3
        x = b0 * q[k, 0] + b1 * q[k + 1, 0] + b2 * q[k + 2, 0] + b3 * q[k + 3, 0]
        y = b0 * q[k, 1] + b1 * q[k + 1, 1] + b2 * q[k + 2, 1] + b3 * q[k + 3, 1]
        z = b0 * q[k, 2] + b1 * q[k + 1, 2] + b2 * q[k + 2, 2] + b3 * q[k + 3, 2]
        if is_blocked(grid, frame, x, y, z):
            return phase
    return -1.0
