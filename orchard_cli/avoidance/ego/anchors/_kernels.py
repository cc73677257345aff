"""The pairs of a point on an obstacle's surface and a direction that push a curve off it."""

from __future__ import annotations

import numpy as np
from numba import njit

from orchard_cli.avoidance.ego.cells._kernels import is_blocked, leg_blocked
from orchard_cli.avoidance.ego.search._kernels import find_way

FIXED = 3  # control points at each end that never move
MOST = 24  # pairs that one control point can have
NONE, BLOCKED = 0, -1
_STEP = 0.1  # m, of the walk back from the way round
_AWAY = 0.1  # m beyond all of its planes an occupied point is a new obstacle's


@njit(cache=True, nogil=True)
def _is_new(q, i, grid, frame, places, pushes, counts):
    """Whether a control point is in an obstacle that none of its pairs pushes it out of."""
    if not is_blocked(grid, frame, q[i, 0], q[i, 1], q[i, 2]):
        return False
    for m in range(counts[i]):
        beyond = 0.0
        for c in range(3):
            beyond += (q[i, c] - places[i, m, c]) * pushes[i, m, c]
        if beyond < _AWAY:
            return False
    return True


@njit(cache=True, nogil=True)
def _meet(q, j, way, length, out):
    """Where the way crosses the plane through Q_j across Q_j-1 to Q_j+1, nearest to Q_j."""
    nx, ny, nz = q[j + 1, 0] - q[j - 1, 0], q[j + 1, 1] - q[j - 1, 1], q[j + 1, 2] - q[j - 1, 2]
    least = np.inf
    before = 0.0
    for m in range(length):
        side = (way[m, 0] - q[j, 0]) * nx + (way[m, 1] - q[j, 1]) * ny + (way[m, 2] - q[j, 2]) * nz
        if m > 0 and before * side <= 0.0 and before != side:
            t = before / (before - side)
            x = way[m - 1, 0] + t * (way[m, 0] - way[m - 1, 0])
            y = way[m - 1, 1] + t * (way[m, 1] - way[m - 1, 1])
            z = way[m - 1, 2] + t * (way[m, 2] - way[m - 1, 2])
            away = (x - q[j, 0]) ** 2 + (y - q[j, 1]) ** 2 + (z - q[j, 2]) ** 2
            if away < least:
                least = away
                out[0], out[1], out[2] = x, y, z
        before = side
    return least < np.inf


@njit(cache=True, nogil=True)
def _pair(q, j, way, length, grid, frame, place, push):
    """The pair of one control point: a point of the obstacle's surface and the way out."""
    at = np.empty(3)
    if not _meet(q, j, way, length, at):
        return False
    far = np.sqrt((at[0] - q[j, 0]) ** 2 + (at[1] - q[j, 1]) ** 2 + (at[2] - q[j, 2]) ** 2)
    if far < 1e-3:
        return False
    for c in range(3):
        push[c], place[c] = (at[c] - q[j, c]) / far, q[j, c]
    for s in range(int(far / _STEP) + 2):
        back = min(s * _STEP, far)
        x, y, z = at[0] - back * push[0], at[1] - back * push[1], at[2] - back * push[2]
        if is_blocked(grid, frame, x, y, z):
            for c in range(3):
                place[c] = at[c] - max(back - _STEP, 0.0) * push[c]
            break
    return True


@njit(cache=True, nogil=True)
def _fill(low, high, found, places, pushes, counts):
    """Keep the new pairs of points [low, high); those without one take their neighbour's."""
    for j in range(low, high):
        source = -1
        for away in range(high - low):
            if j - away >= low and found[j - away]:
                source = j - away
                break
            if j + away < high and found[j + away]:
                source = j + away
                break
        if source >= 0 and source != j:
            for c in range(3):
                places[j, counts[j], c] = places[source, counts[source], c]
                pushes[j, counts[j], c] = pushes[source, counts[source], c]
    for j in range(low, high):
        counts[j] += 1


@njit(cache=True, nogil=True)
def add_pairs(q, checked, only_new, grid, frame, places, pushes, counts):
    """Pairs for every blocked stretch of the control polygon q (n, 3) that begins before `checked`.

    A stretch reaches from the last free control point before an obstacle to the first behind it;
    A* finds the way round between the two. `only_new`: just for stretches with a point in an
    obstacle that is new to it. Returns how many points got a pair, BLOCKED without a way round.
    """
    n = q.shape[0]
    found = np.zeros(n, dtype=np.bool_)
    way = np.empty((1024, 3))
    gained, i = 0, 1
    while i < checked:
        if not leg_blocked(grid, frame, q[i], q[i + 1]):
            i += 1
            continue
        a, b, new = i, i + 1, not only_new
        while b < n - 1 and leg_blocked(grid, frame, q[b], q[b + 1]):
            b += 1
        for j in range(max(a + 1, FIXED), min(b, n - FIXED)):
            new |= _is_new(q, j, grid, frame, places, pushes, counts)
        i = b
        if not new:
            continue
        if is_blocked(grid, frame, q[a, 0], q[a, 1], q[a, 2]) or is_blocked(
            grid, frame, q[b, 0], q[b, 1], q[b, 2]
        ):
            return BLOCKED
        a, b = _widened(q, a, b, grid, frame)
        length = find_way(grid, frame, q[a], q[b], way)
        if length == 0:
            return BLOCKED
        low, high, some = max(a + 1, FIXED), min(b, n - FIXED), False
        full = False
        for j in range(low, high):
            full |= counts[j] >= MOST
        if full:
            continue
        for j in range(low, high):
            m = counts[j]
            found[j] = _pair(q, j, way, length, grid, frame, places[j, m], pushes[j, m])
            some |= found[j]
        if some:
            _fill(low, high, found, places, pushes, counts)
            gained += high - low
    return gained


@njit(cache=True, nogil=True)
def _widened(q, a, b, grid, frame):
    """A stretch with a control point inside, even where an obstacle lies between two of them."""
    if b - a < 2:
        if a > 0 and not is_blocked(grid, frame, q[a - 1, 0], q[a - 1, 1], q[a - 1, 2]):
            a -= 1
        c = b + 1
        if c < q.shape[0] and not is_blocked(grid, frame, q[c, 0], q[c, 1], q[c, 2]):
            b = c
    return a, b
