"""A* in three dimensions over the inflated cells."""

from __future__ import annotations

import numpy as np
from numba import njit

from orchard_cli.motion.search._kernels import _pop, _push

_BUDGET = 12000  # cells that a search may expand: some 5 ms
_TIE = 1.0005  # of the heuristic: of equal ways the one nearer to the goal first
_R2, _R3 = np.sqrt(2.0) - 1.0, np.sqrt(3.0) - np.sqrt(2.0)


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
