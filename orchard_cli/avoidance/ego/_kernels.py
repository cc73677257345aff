"""The loops of one replan: fit, rebound, refine."""

from __future__ import annotations

import numpy as np
from numba import njit

from .anchors._kernels import BLOCKED, FIXED, MOST, add_pairs
from .cells._kernels import first_hit
from .cost._kernels import COLLIDE, NEW, minimise

FREE, NO_WAY, AT_ONCE, STILL_HIT = 0, 1, 2, 3
_REBOUNDS, _RESTARTS = 20, 3
_PER_SEGMENT = 5  # samples of the check: every 0.1 m at 0.4 m between control points


@njit(cache=True, nogil=True)
def fit(q, knots):
    """Least squares: the free points of q (n, 3) so that the curve's knots are `knots` (n - 2, 3).

    Normal equations of (Q_i + 4 Q_i+1 + Q_i+2) / 6, two side diagonals, by Cholesky, in place.
    """
    n = q.shape[0]
    f = n - 2 * FIXED
    band, right = np.zeros((f, 3)), np.zeros((f, 3))
    stencil = np.array([1.0, 4.0, 1.0])
    rest = np.empty(3)
    for row in range(1, n - 3):
        for c in range(3):
            rest[c] = 6 * knots[row, c]
            for s in range(3):
                if not FIXED <= row + s < n - FIXED:
                    rest[c] -= stencil[s] * q[row + s, c]
        for s in range(3):
            i = row + s - FIXED
            if not 0 <= i < f:
                continue
            for c in range(3):
                right[i, c] += stencil[s] * rest[c]
            for r in range(s + 1):
                if i - (s - r) >= 0:
                    band[i, s - r] += stencil[s] * stencil[r]
    for i in range(f):
        for k in range(min(i, 2), -1, -1):
            value = band[i, k]
            for m in range(max(i - 2, 0), i - k):
                value -= band[i, i - m] * band[i - k, i - k - m]
            band[i, k] = value / band[i - k, 0] if k > 0 else np.sqrt(value)
    for c in range(3):
        for i in range(f):
            for k in range(1, min(i, 2) + 1):
                right[i, c] -= band[i, k] * right[i - k, c]
            right[i, c] /= band[i, 0]
        for i in range(f - 1, -1, -1):
            for k in range(1, min(f - 1 - i, 2) + 1):
                right[i, c] -= band[i + k, k] * right[i + k, c]
            right[i, c] /= band[i, 0]
            q[FIXED + i, c] = right[i, c]


@njit(cache=True, nogil=True)
def rebound(q, interval, weights, limits, grid, frame, share, counts):
    """Push the curve q (n, 3) off what it touches, in place. Returns FREE or what went wrong.

    `share` of the curve is looked at. `counts` (n,) receives the number of pairs of each point.
    """
    n = q.shape[0]
    places, pushes = np.empty((n, MOST, 3)), np.empty((n, MOST, 3))
    nothing = np.empty((0, 3))
    weights = weights.copy()
    counts[:] = 0
    last = share * (n - 3)
    checked = int(last) + 1
    if add_pairs(q, checked, False, grid, frame, places, pushes, counts) == BLOCKED:
        return NO_WAY
    rebounds = restarts = 0
    while True:
        outcome = minimise(
            q, interval, weights, limits, checked, grid, frame, places, pushes, counts,
            nothing, nothing,
        )  # fmt: skip
        if outcome == NEW:
            rebounds += 1
            if rebounds > _REBOUNDS:
                return STILL_HIT
            continue
        if outcome == BLOCKED:
            return NO_WAY
        hit = first_hit(q, 0.0, last, _PER_SEGMENT, grid, frame)
        if hit < 0:
            return FREE
        restarts += 1
        if hit < 1.0 or restarts > _RESTARTS:
            return AT_ONCE if hit < 1.0 else STILL_HIT
        if add_pairs(q, checked, False, grid, frame, places, pushes, counts) == BLOCKED:
            return NO_WAY
        weights[COLLIDE] *= 2


@njit(cache=True, nogil=True)
def refine(q, interval, weights, limits, grid, frame, share, wanted, tangents):
    """Smooth and slow a stretched curve while it keeps its shape, in place. FREE or STILL_HIT."""
    n = q.shape[0]
    none = np.empty((n, 0, 3))
    counts = np.zeros(n, dtype=np.int64)
    minimise(q, interval, weights, limits, 0, grid, frame, none, none, counts, wanted, tangents)
    hit = first_hit(q, 0.0, share * (n - 3), _PER_SEGMENT, grid, frame)
    return FREE if hit < 0 else STILL_HIT
