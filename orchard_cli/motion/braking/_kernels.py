"""Slowing down along a control polygon, knot by knot."""

from __future__ import annotations

import numpy as np
from numba import njit

_SHARES = 9  # of the braking asked for, where a bend needs the rest of the limit


@njit(cache=True, nogil=True)
def _along(way, lengths, at, point):
    """The place `at` metres along the polyline `way` (m, 3) with `lengths` (m,)."""
    j = np.searchsorted(lengths, at)
    j = min(max(j, 1), lengths.shape[0] - 1)
    step = lengths[j] - lengths[j - 1]
    u = min(max((at - lengths[j - 1]) / step, 0.0), 1.0) if step > 0 else 1.0
    for c in range(3):
        point[c] = way[j - 1, c] + u * (way[j, c] - way[j - 1, c])


@njit(cache=True, nogil=True)
def slow(control, knot, most, until, out):
    """Control points (k, 3) that follow control[: knot + 3] and slow down along its polygon.

    Two steps between control points differ by at most `most` m (deceleration times interval²),
    less along the path where the bend itself needs some of it. Ends with two equal points when
    `until` is 0, else with the first step of at most `until` m. Fills `out`, as far as it has
    room. Returns how many points there are; -1 when the trajectory comes to its end sooner.
    """
    n = control.shape[0] - knot - 2
    if n < 2:
        return -1
    way = control[knot + 2 :]
    lengths = np.zeros(n)
    for i in range(1, n):
        d = way[i] - way[i - 1]
        lengths[i] = lengths[i - 1] + np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        if lengths[i] > 20.0:  # m: nobody brakes for so long
            n = i + 1
            break
    lengths = lengths[:n]
    before, last = control[knot + 1].copy(), control[knot + 2].copy()
    point, best_point = np.empty(3), np.empty(3)
    d = last - before
    step, at, count, here = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), 0.0, 0, 0
    while step > until:
        while here < n - 2 and lengths[here + 1] <= at:
            here += 1
        own = lengths[here + 1] - lengths[here]
        best, chosen = np.inf, 0.0
        for s in range(_SHARES):
            wanted = max(min(step - (1 - s / (_SHARES - 1)) * most, own), step - most, 0.0)
            _along(way, lengths, at + wanted, point)
            change = 0.0
            for c in range(3):
                change += (point[c] - 2 * last[c] + before[c]) ** 2
            change = np.sqrt(change)
            if change < best:
                best, chosen = change, wanted
                best_point[:] = point
            if change <= most * (1 + 1e-9):
                break
        step = chosen
        at += step
        if at >= lengths[n - 1]:
            return -1
        if count < out.shape[0]:
            out[count] = best_point
        count += 1
        before[:], last[:] = last, best_point
    if until == 0.0:
        if count < out.shape[0]:
            out[count] = last
        count += 1
    return count


@njit(cache=True, nogil=True)
def travelled(control, phase):
    """Path length along the control polygon up to a phase in knots: knot k lies beside k + 1."""
    total, at = 0.0, phase + 1.0
    for i in range(control.shape[0] - 1):
        if i >= at:
            break
        d = control[i + 1] - control[i]
        share = min(at - i, 1.0)
        total += share * np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    return total


@njit(cache=True, nogil=True)
def latest(control, knot, phase, room, most, out):
    """The latest knot from `knot` on at which braking by `most` still ends within `room` m.

    `room` is counted from `phase` along the control polygon. Returns (knot or -1: none, points in
    `out` or -1: it comes to rest by itself).
    """
    here = travelled(control, phase)
    chosen, points = -1, 0
    for k in range(knot, control.shape[0] - 3):
        begun = travelled(control, k + 1.0)
        if begun - here > room:
            break
        count = slow(control, k, most, 0.0, out)
        rest = begun
        if count < 0:
            rest = travelled(control, control.shape[0])
        else:
            for i in range(count):
                d = out[i] - (control[k + 2] if i == 0 else out[i - 1])
                rest += np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        if rest - here > room:
            break
        chosen, points = k, count
        if count < 0:
            break
    if chosen >= 0 and points >= 0:
        points = slow(control, chosen, most, 0.0, out)
    return chosen, points
