"""Plain and improved A* over a grid of cells, with the same heap and tables (Huang 2021, §2.4)."""

from __future__ import annotations

import numpy as np
from numba import njit

from orchard_cli.motion.search._kernels import _pop, _push


@njit(cache=True, nogil=True, inline="always")
def _towards(step, x, y, z):
    """Whether a step leads into the half of directions about the line to the goal (x, y, z).

    Steps come in opposite pairs, of which exactly one leads there: 4 of 8, 13 of 26. Across the
    line, where both are as good, the first by its signs is kept.
    """
    along = step[0] * x + step[1] * y + step[2] * z
    if along != 0:
        return along > 0
    if step[0] != 0:
        return step[0] > 0
    return step[1] > 0 if step[1] != 0 else step[2] > 0


@njit(cache=True, nogil=True, inline="always")
def _passable(blocked, i, j, k, di, dj, dk):
    """Whether a step leads onto a free cell of the grid without cutting a corner."""
    a, b, c = i + di, j + dj, k + dk
    nx, ny, nz = blocked.shape
    if not (0 <= a < nx and 0 <= b < ny and 0 <= c < nz) or blocked[a, b, c]:
        return False
    if abs(di) + abs(dj) + abs(dk) == 1:
        return True
    if blocked[a, j, k] or blocked[i, b, k] or blocked[i, j, c]:
        return False
    return not (blocked[a, b, k] or blocked[a, j, c] or blocked[i, b, c])


@njit(cache=True, nogil=True)
def find_path(
    blocked,
    steps,
    lengths,
    start,
    goal,
    dynamic,
    pruned,
    run,
    stamp,
    cost,
    parents,
    keys,
    heap,
    path,
):
    """A* from `start` to `goal` (3,) over free cells of `blocked` (nx, ny, nz).

    `steps` (m, 3): neighbours, in opposite pairs, with their `lengths` (m,). `dynamic`: the
    heuristic is weighted by 1 + r / R (eq. 7), else by 1 (eq. 6). `pruned`: only the half of the
    steps that leads towards the goal, and all of them from a cell that has none of these
    (§2.4.2). `run` differs from every number in `stamp` (cells,): tables are not cleared between
    calls; a cell's is -run when it is closed. Fills `path` (n, 3) from start to goal. Returns
    (its length, or 0 without a way; cells expanded).
    """
    _, ny, nz = blocked.shape
    source = (start[0] * ny + start[1]) * nz + start[2]
    target = (goal[0] * ny + goal[1]) * nz + goal[2]
    whole = np.sqrt(float(((goal - start) ** 2).sum()))
    stamp[source], cost[source], parents[source] = run, 0.0, -1
    size = _push(keys, heap, 0, 0.0, source)
    expanded = 0
    while size > 0:
        here = heap[0]
        size = _pop(keys, heap, size)
        if stamp[here] == -run:
            continue
        stamp[here] = -run
        expanded += 1
        if here == target:
            return _unwind(parents, target, ny, nz, path), expanded
        i, j, k = here // (ny * nz), here // nz % ny, here % nz
        x, y, z = goal[0] - i, goal[1] - j, goal[2] - k
        enclosed = False
        while True:
            onward = 0
            for s in range(steps.shape[0]):
                if pruned and not enclosed and not _towards(steps[s], x, y, z):
                    continue
                di, dj, dk = steps[s, 0], steps[s, 1], steps[s, 2]
                if not _passable(blocked, i, j, k, di, dj, dk):
                    continue
                there = here + (di * ny + dj) * nz + dk
                if stamp[there] == -run:
                    continue
                onward += 1
                g = cost[here] + lengths[s]
                if stamp[there] == run and g >= cost[there]:
                    continue
                stamp[there], cost[there], parents[there] = run, g, here
                left = np.sqrt(float((x - di) ** 2 + (y - dj) ** 2 + (z - dk) ** 2))
                weight = 1.0 + left / whole if dynamic else 1.0
                size = _push(keys, heap, size, g + weight * left, there)
            if onward > 0 or enclosed or not pruned:
                break
            enclosed = True
    return 0, expanded


@njit(cache=True, nogil=True)
def _unwind(parents, target, ny, nz, path):
    length, cell = 0, target
    while cell >= 0:
        length, cell = length + 1, parents[cell]
    cell = target
    for n in range(length - 1, -1, -1):
        path[n, 0], path[n, 1], path[n, 2] = cell // (ny * nz), cell // nz % ny, cell % nz
        cell = parents[cell]
    return length


@njit(cache=True, nogil=True)
def sees(blocked, a, b):
    """Whether every cell that the straight line between two cells' centres touches is free."""
    i, j, k = a[0], a[1], a[2]
    dx, dy, dz = b[0] - i, b[1] - j, b[2] - k
    sx, sy, sz = np.sign(dx), np.sign(dy), np.sign(dz)
    every_x = 1.0 / abs(dx) if dx else np.inf  # of the line, from wall to wall of cells across x
    every_y = 1.0 / abs(dy) if dy else np.inf
    every_z = 1.0 / abs(dz) if dz else np.inf
    x, y, z = 0.5 * every_x, 0.5 * every_y, 0.5 * every_z  # the next wall
    while True:
        ahead = min(x, y, z)
        if ahead > 1.0:
            return True
        ahead += 1e-9  # walls met together are a diagonal step
        di, dj, dk = 0, 0, 0
        if x <= ahead:
            di, x = sx, x + every_x
        if y <= ahead:
            dj, y = sy, y + every_y
        if z <= ahead:
            dk, z = sz, z + every_z
        if not _passable(blocked, i, j, k, di, dj, dk):
            return False
        i, j, k = i + di, j + dj, k + dk


@njit(cache=True, nogil=True)
def pull_straight(blocked, path, length, reach, out):
    """Keep of a path (n, 3) only the key turning points: each is seen from the one before.

    From each the farthest corner of the path that is seen is taken, looking `reach` corners past
    the last seen. Fills `out`; returns its length. The result is never longer than the path.
    """
    corners = 1
    for n in range(1, length - 1):
        for axis in range(3):
            if path[n + 1, axis] - path[n, axis] != path[n, axis] - path[n - 1, axis]:
                path[corners] = path[n]  # behind n: nothing that is still read is lost
                corners += 1
                break
    path[corners] = path[length - 1]
    corners += 1
    out[0] = path[0]
    kept, here = 1, 0
    while here < corners - 1:
        farthest = here + 1
        n = here + 2
        while n < corners and n <= farthest + reach:
            if sees(blocked, path[here], path[n]):
                farthest = n
            n += 1
        here = farthest
        out[kept] = path[here]
        kept += 1
    return kept


@njit(cache=True, nogil=True)
def find_way(
    blocked, steps, lengths, start, goal, dynamic, pruned, reach,
    run, stamp, cost, parents, keys, heap, path, out,
):  # fmt: skip
    """`find_path`, then with a `reach` above 0 `pull_straight`; the way is in `out` (n, 3).

    Where half of the steps lead nowhere, all are tried (§2.4.2), numbered `run + 1`.
    """
    length, expanded = find_path(
        blocked, steps, lengths, start, goal, dynamic, pruned,
        run, stamp, cost, parents, keys, heap, path,
    )  # fmt: skip
    if length == 0 and pruned:
        length, more = find_path(
            blocked, steps, lengths, start, goal, dynamic, False,
            run + 1, stamp, cost, parents, keys, heap, path,
        )  # fmt: skip
        expanded += more
    if length == 0:
        return 0, expanded
    if reach > 0:
        return pull_straight(blocked, path, length, reach, out), expanded
    out[:length] = path[:length]
    return length, expanded
