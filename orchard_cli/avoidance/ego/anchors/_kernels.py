"""Obstacles as the method sees them: inflated cells, ways round, and pairs that push off.

`grid` (nx, ny, nz) holds the inflated obstacles and `frame` its lower corner and cell, m. Outside
the grid everything is an obstacle.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from orchard_cli.motion.search._kernels import _pop, _push

FIXED = 3  # control points at each end that never move
MOST = 24  # pairs that one control point can have
NONE, BLOCKED = 0, -1
_BUDGET = 60000  # cells that a search may expand
_STEP = 0.1  # m, of the walk back from the way round
_AWAY = 0.1  # m beyond all of its planes an occupied point is a new obstacle's
_TIE = 1.0005  # of the heuristic: of equal ways the one nearer to the goal first
_R2, _R3 = np.sqrt(2.0) - 1.0, np.sqrt(3.0) - np.sqrt(2.0)


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


@njit(cache=True, nogil=True)
def _ends(grid, frame, start, goal):
    """Flat cells of start and goal. The goal's is whole cells away from the start's, rounded: two
    places at one height, on the edge between two cells, are then in one layer."""
    source, near, exact = np.empty(3, np.int64), np.empty(3, np.int64), np.empty(3, np.int64)
    for c in range(3):
        source[c] = int(np.floor((start[c] - frame[c]) / frame[3]))
        near[c] = source[c] + int(np.round((goal[c] - start[c]) / frame[3]))
        exact[c] = int(np.floor((goal[c] - frame[c]) / frame[3]))
    usable = True
    for c in range(3):
        usable &= 0 <= near[c] < grid.shape[c]
    target = near if usable and not grid[near[0], near[1], near[2]] else exact
    ny, nz = grid.shape[1], grid.shape[2]
    return (
        (source[0] * ny + source[1]) * nz + source[2],
        (target[0] * ny + target[1]) * nz + target[2],
    )


@njit(cache=True, nogil=True)
def find_way(grid, frame, start, goal, way):
    """A* over 26 neighbours between two free places (3,). Fills `way` (m, 3).

    Its points are whole cells away from the start, so that a way on its level stays there.

    Returns the number of points, 0 when there is no way within the budget.
    """
    nx, ny, nz = grid.shape
    cells = nx * ny * nz
    state = np.zeros(cells, dtype=np.uint8)  # 1 reached, 2 done
    cost, parents = np.empty(cells, dtype=np.float32), np.empty(cells, dtype=np.int32)
    keys, heap = np.empty(26 * _BUDGET), np.empty(26 * _BUDGET, dtype=np.int32)
    source, target = _ends(grid, frame, start, goal)
    gi, gj, gk = target // (ny * nz), target // nz % ny, target % nz
    state[source], cost[source], parents[source] = 1, 0.0, -1
    size = _push(keys, heap, 0, 0.0, source)
    expanded = 0
    while size > 0 and expanded < _BUDGET:
        here = heap[0]
        size = _pop(keys, heap, size)
        if here == target:
            return _trace(parents, here, source, ny, nz, start, frame[3], way)
        if state[here] == 2:
            continue
        state[here] = 2
        expanded += 1
        i, j, k = here // (ny * nz), here // nz % ny, here % nz
        for a in range(max(0, i - 1), min(nx, i + 2)):
            for b in range(max(0, j - 1), min(ny, j + 2)):
                for c in range(max(0, k - 1), min(nz, k + 2)):
                    there = (a * ny + b) * nz + c
                    if grid[a, b, c] or state[there] == 2:
                        continue
                    g = cost[here] + np.sqrt(float((a - i) ** 2 + (b - j) ** 2 + (c - k) ** 2))
                    if state[there] == 0 or g < cost[there] - 1e-4:
                        state[there], cost[there], parents[there] = 1, g, here
                        h = _octile(abs(a - gi), abs(b - gj), abs(c - gk))
                        size = _push(keys, heap, size, g + _TIE * h, there)
    return 0


@njit(cache=True, nogil=True)
def _octile(dx, dy, dz):
    """Length of the shortest way over 26 neighbours when nothing is in it."""
    most, least = max(dx, dy, dz), min(dx, dy, dz)
    middle = dx + dy + dz - most - least
    return most + _R2 * middle + _R3 * least


@njit(cache=True, nogil=True)
def _trace(parents, target, source, ny, nz, start, size, way):
    length, cell = 0, target
    while cell >= 0:
        length += 1
        cell = parents[cell]
    if length > way.shape[0]:
        return 0
    cell = target
    for n in range(length - 1, -1, -1):
        way[n, 0] = start[0] + (cell // (ny * nz) - source // (ny * nz)) * size
        way[n, 1] = start[1] + (cell // nz % ny - source // nz % ny) * size
        way[n, 2] = start[2] + (cell % nz - source % nz) * size
        cell = parents[cell]
    return length


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
