"""A* over the cells of a distance field, and the straightening of what it finds."""

from __future__ import annotations

import numpy as np
from numba import njit

_DIAGONAL = np.sqrt(2.0)


@njit(cache=True, nogil=True)
def _push(heap_key, heap_cell, size, key, cell):
    i = size
    while i > 0:
        parent = (i - 1) >> 1
        if heap_key[parent] <= key:
            break
        heap_key[i], heap_cell[i] = heap_key[parent], heap_cell[parent]
        i = parent
    heap_key[i], heap_cell[i] = key, cell
    return size + 1


@njit(cache=True, nogil=True)
def _pop(heap_key, heap_cell, size):
    """Drop the root; returns the new size."""
    size -= 1
    key, cell = heap_key[size], heap_cell[size]
    i = 0
    while 2 * i + 1 < size:
        child = 2 * i + 1
        if child + 1 < size and heap_key[child + 1] < heap_key[child]:
            child += 1
        if heap_key[child] >= key:
            break
        heap_key[i], heap_cell[i] = heap_key[child], heap_cell[child]
        i = child
    heap_key[i], heap_cell[i] = key, cell
    return size


@njit(cache=True, nogil=True)
def _strayed(x, y, near):
    """Distance in cells from a cell to the nearest of the points `near` (n, 2)."""
    least = np.inf
    for i in range(near.shape[0]):
        dx, dy = x - near[i, 0], y - near[i, 1]
        least = min(least, dx * dx + dy * dy)
    return np.sqrt(least)


@njit(cache=True, nogil=True)
def find_path(values, limit, start, goal, near, stray, path):
    """A* from cell to cell (Liu 2024, eq. 14: f = g + h, h the Euclidean distance).

    A cell is free where `values` >= `limit`. Steps go to 8 neighbours, a
    diagonal one only between free sides (no corner is cut), and cost their length times
    1 + stray * distance to the nearest of `near` (n, 2), in cells. Fills `path` (m, 2) from start
    to goal. Returns (its length or 0 when there is no way or no room, cells expanded).
    """
    nx, ny = values.shape
    cells = nx * ny
    cost = np.full(cells, np.inf, dtype=np.float64)
    factor = np.zeros(cells, dtype=np.float32)
    closed = np.zeros(cells, dtype=np.bool_)
    parents = np.empty(cells, dtype=np.int32)
    heap_key, heap_cell = np.empty(8 * cells + 1), np.empty(8 * cells + 1, dtype=np.int32)
    source, target = start[0] * ny + start[1], goal[0] * ny + goal[1]
    cost[source], parents[source] = 0.0, -1
    size = _push(heap_key, heap_cell, 0, 0.0, source)
    expanded = 0
    while size > 0:
        here = heap_cell[0]
        size = _pop(heap_key, heap_cell, size)
        if closed[here]:
            continue
        closed[here] = True
        if here == target:
            return _unwind(parents, here, ny, path), expanded
        expanded += 1
        i, j = here // ny, here % ny
        for di in range(-1, 2):
            for dj in range(-1, 2):
                a, b = i + di, j + dj
                if not (0 <= a < nx and 0 <= b < ny):
                    continue
                there = a * ny + b
                if closed[there] or values[a, b] < limit:
                    continue
                diagonal = di != 0 and dj != 0
                if diagonal and (values[a, j] < limit or values[i, b] < limit):
                    continue
                if factor[there] == 0:
                    factor[there] = 1 + (stray * _strayed(a, b, near) if stray > 0 else 0.0)
                g = cost[here] + (_DIAGONAL if diagonal else 1.0) * factor[there]
                if g < cost[there]:
                    cost[there], parents[there] = g, here
                    h = np.sqrt(float((a - goal[0]) ** 2 + (b - goal[1]) ** 2))
                    size = _push(heap_key, heap_cell, size, g + h, there)
    return 0, expanded


@njit(cache=True, nogil=True)
def _unwind(parents, target, ny, path):
    length = 0
    cell = target
    while cell >= 0:
        length += 1
        cell = parents[cell]
    if length > path.shape[0]:
        return 0
    cell = target
    for k in range(length - 1, -1, -1):
        path[k, 0], path[k, 1] = cell // ny, cell % ny
        cell = parents[cell]
    return length


@njit(cache=True, nogil=True)
def _sees(values, limit, x0, y0, x1, y1):
    """Whether the straight line between two cells' centres stays on free cells."""
    dx, dy = x1 - x0, y1 - y0
    steps = int(np.ceil(2 * max(abs(dx), abs(dy))))
    for s in range(1, steps):
        x = int(np.floor(x0 + dx * s / steps + 0.5))
        y = int(np.floor(y0 + dy * s / steps + 0.5))
        if values[x, y] < limit:
            return False
    return True


@njit(cache=True, nogil=True)
def straighten(values, limit, path, length, out):
    """Drop the points of a path (m, 2) that are not needed to see from one to the next.

    Fills `out`; returns its length. The result is never longer than the path.
    """
    out[0] = path[0]
    kept, here = 1, 0
    while here < length - 1:
        low, high = here + 1, length - 1
        if not _sees(values, limit, path[here, 0], path[here, 1], path[high, 0], path[high, 1]):
            while high - low > 1:  # sight lost once is mostly lost for good: halving is enough
                middle = (low + high) // 2
                if _sees(
                    values, limit, path[here, 0], path[here, 1],
                    path[middle, 0], path[middle, 1],
                ):  # fmt: skip
                    low = middle
                else:
                    high = middle
            high = low
        here = high
        out[kept] = path[here]
        kept += 1
    return kept
