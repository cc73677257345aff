"""Searches timed without the calls from Python around them."""

from __future__ import annotations

from numba import njit

from orchard_cli.avoidance.astar.search._kernels import find_way


@njit(cache=True, nogil=True)
def search_often(
    times, blocked, steps, lengths, start, goal, dynamic, pruned, reach,
    run, stamp, cost, parents, keys, heap, path, out,
):  # fmt: skip
    """`find_way` again and again, each with two numbers from `run` on; the way's length."""
    length = 0
    for n in range(times):
        length, _ = find_way(
            blocked, steps, lengths, start, goal, dynamic, pruned, reach,
            run + 2 * n, stamp, cost, parents, keys, heap, path, out,
        )  # fmt: skip
    return length
