"""Cost of the control points and its minimiser.

Control points are (n, 3); the first and last three never move. Each term adds its gradient to
`grad` (n, 3) and returns its value.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from orchard_cli.avoidance.ego.anchors._kernels import BLOCKED, FIXED, NONE, add_pairs

SMOOTH, COLLIDE, FEASIBLE, FIT = 0, 1, 2, 3  # places in `weights`
SPEED, ACCELERATION, DISTANCE = 0, 1, 2  # places in `limits`
CALM, NEW = 0, 1  # outcomes of `minimise`, besides BLOCKED
_MEMORY = 16
_ITERATIONS = 200
_TOLERANCE = 0.01  # of the gradient's length, in units of the curve's size
_WATCH_FROM = 3  # evaluations before new obstacles are looked for
_SETTLED = 0.1  # m², smoothness per free point from which new obstacles are looked for
_ARMIJO, _HALVINGS = 1e-4, 20
_STRETCH = 25.0  # how much cheaper it is to lag on the fitted curve than to leave it


@njit(cache=True, nogil=True)
def smoothness(q, weight, grad):
    """Squared third differences: the jerk, whatever the interval (Zhou 2020, eq. 3)."""
    total = 0.0
    for i in range(q.shape[0] - 3):
        for c in range(3):
            j = q[i + 3, c] - 3 * q[i + 2, c] + 3 * q[i + 1, c] - q[i, c]
            total += j * j
            pull = 2 * weight * j
            grad[i + 3, c] += pull
            grad[i + 2, c] -= 3 * pull
            grad[i + 1, c] += 3 * pull
            grad[i, c] -= pull
    return total


@njit(cache=True, nogil=True)
def collision(q, places, pushes, counts, safe, weight, grad):
    """How far each point is short of `safe` m beyond its planes (Zhou 2020, eqs. 4-6).

    Cubic up to `safe`, then continued as a parabola with the same value, slope and curvature.
    """
    total = 0.0
    for i in range(FIXED, q.shape[0] - FIXED):
        for m in range(counts[i]):
            short = safe
            for c in range(3):
                short -= (q[i, c] - places[i, m, c]) * pushes[i, m, c]
            if short <= 0.0:
                continue
            if short < safe:
                total += short**3
                slope = 3 * short * short
            else:
                total += 3 * safe * short * short - 3 * safe * safe * short + safe**3
                slope = 6 * safe * short - 3 * safe * safe
            for c in range(3):
                grad[i, c] -= weight * slope * pushes[i, m, c]
    return total


@njit(cache=True, nogil=True)
def feasibility(q, interval, speed, acceleration, weight, grad):
    """Squared excess of velocity (over interval²) and acceleration, axis by axis."""
    total = 0.0
    square = interval * interval
    for i in range(q.shape[0] - 1):
        for c in range(3):
            v = (q[i + 1, c] - q[i, c]) / interval
            excess = abs(v) - speed
            if excess > 0.0:
                total += excess * excess / square
                pull = np.sign(v) * 2 * weight * excess / (square * interval)
                grad[i + 1, c] += pull
                grad[i, c] -= pull
    for i in range(q.shape[0] - 2):
        for c in range(3):
            a = (q[i + 2, c] - 2 * q[i + 1, c] + q[i, c]) / square
            excess = abs(a) - acceleration
            if excess > 0.0:
                total += excess * excess
                pull = np.sign(a) * 2 * weight * excess / square
                grad[i + 2, c] += pull
                grad[i + 1, c] -= 2 * pull
                grad[i, c] += pull
    return total


@njit(cache=True, nogil=True)
def fitness(q, wanted, tangents, weight, grad):
    """Offset of the knots from `wanted` (n - 2, 3): dear across the curve, cheap along it."""
    total = 0.0
    x = np.empty(3)
    for i in range(q.shape[0] - 2):
        along = whole = 0.0
        for c in range(3):
            x[c] = (q[i, c] + 4 * q[i + 1, c] + q[i + 2, c]) / 6 - wanted[i, c]
            along += x[c] * tangents[i, c]
            whole += x[c] * x[c]
        total += along * along / _STRETCH + whole - along * along
        for c in range(3):
            pull = 2 * weight * (x[c] + along * tangents[i, c] * (1 / _STRETCH - 1)) / 6
            grad[i, c] += pull
            grad[i + 1, c] += 4 * pull
            grad[i + 2, c] += pull
    return total


@njit(cache=True, nogil=True)
def total_cost(
    q, interval, weights, limits, places, pushes, counts, wanted, tangents, grad, parts
):  # fmt: skip
    """The weighted sum and its gradient, 0 at the fixed points. parts[0]: smoothness alone."""
    grad[:] = 0.0
    parts[0] = smoothness(q, weights[SMOOTH], grad)
    total = weights[SMOOTH] * parts[0]
    total += weights[FEASIBLE] * feasibility(
        q, interval, limits[SPEED], limits[ACCELERATION], weights[FEASIBLE], grad
    )
    if weights[COLLIDE] > 0:
        total += weights[COLLIDE] * collision(
            q, places, pushes, counts, limits[DISTANCE], weights[COLLIDE], grad
        )
    if weights[FIT] > 0:
        total += weights[FIT] * fitness(q, wanted, tangents, weights[FIT], grad)
    grad[:FIXED] = 0.0
    grad[q.shape[0] - FIXED :] = 0.0
    return total


@njit(cache=True, nogil=True)
def _inner(a, b):
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@njit(cache=True, nogil=True)
def _add(a, factor, b):
    for i in range(a.size):
        a[i] += factor * b[i]


@njit(cache=True, nogil=True)
def _descent(grad, steps, changes, products, kept, newest, out):
    """The L-BFGS direction from `kept` pairs in a ring (Nocedal's two-loop recursion)."""
    alpha = np.empty(_MEMORY)
    out[:] = -grad
    for back in range(kept):
        k = (newest - back) % _MEMORY
        alpha[back] = _inner(steps[k], out) / products[k]
        _add(out, -alpha[back], changes[k])
    if kept > 0:
        out *= products[newest] / _inner(changes[newest], changes[newest])
    else:
        out /= max(np.sqrt(_inner(grad, grad)), 1.0)
    for back in range(kept - 1, -1, -1):
        k = (newest - back) % _MEMORY
        _add(out, alpha[back] - _inner(changes[k], out) / products[k], steps[k])


@njit(cache=True, nogil=True)
def _size(q):
    """How large the curve is: length of all free points' offsets from the first point."""
    total = 0.0
    for i in range(FIXED, q.shape[0] - FIXED):
        for c in range(3):
            total += (q[i, c] - q[0, c]) ** 2
    return np.sqrt(total)


@njit(cache=True, nogil=True)
def minimise(
    q, interval, weights, limits, checked, grid, frame, places, pushes, counts, wanted, tangents
):  # fmt: skip
    """L-BFGS with Armijo backtracking on the points between the fixed ones, in place.

    With `checked` > 0 it looks for new obstacles on the way once the curve has settled. Returns
    CALM at the end, NEW when pairs were added and it has to begin again, BLOCKED without a way.
    """
    n = q.shape[0]
    f = n - 2 * FIXED
    grad, trial_grad, trial = np.zeros((n, 3)), np.zeros((n, 3)), q.copy()
    steps, changes = np.empty((_MEMORY, 3 * f)), np.empty((_MEMORY, 3 * f))
    direction, products, parts = np.empty(3 * f), np.empty(_MEMORY), np.empty(1)
    here, there = q[FIXED : n - FIXED].reshape(3 * f), trial[FIXED : n - FIXED].reshape(3 * f)
    slopes = grad[FIXED : n - FIXED].reshape(3 * f)
    trial_slopes = trial_grad[FIXED : n - FIXED].reshape(3 * f)
    cost = total_cost(
        q, interval, weights, limits, places, pushes, counts, wanted, tangents, grad, parts
    )
    enough = _TOLERANCE * max(_size(q), 1.0)
    kept, newest, evaluations = 0, -1, 1
    for _ in range(_ITERATIONS):
        if np.sqrt(_inner(slopes, slopes)) < enough:
            return CALM
        _descent(slopes, steps, changes, products, kept, newest, direction)
        slope, step, lower = _inner(slopes, direction), 1.0, np.inf
        for _ in range(_HALVINGS):
            for i in range(3 * f):
                there[i] = here[i] + step * direction[i]
            lower = total_cost(
                trial, interval, weights, limits, places, pushes, counts, wanted, tangents,
                trial_grad, parts,
            )  # fmt: skip
            evaluations += 1
            if lower <= cost + _ARMIJO * step * slope:
                break
            step *= 0.5
        if not lower < cost:
            if kept == 0:
                return CALM
            kept = 0  # start again downhill
            continue
        ring = (newest + 1) % _MEMORY
        for i in range(3 * f):
            steps[ring, i] = step * direction[i]
            changes[ring, i] = trial_slopes[i] - slopes[i]
        products[ring] = _inner(steps[ring], changes[ring])
        if products[ring] > 1e-10 * _inner(steps[ring], steps[ring]):
            newest, kept = ring, min(kept + 1, _MEMORY)
        q[:], grad[:] = trial, trial_grad
        cost = lower
        if checked > 0 and evaluations > _WATCH_FROM and parts[0] < _SETTLED * f:
            gained = add_pairs(q, checked, True, grid, frame, places, pushes, counts)
            if gained != NONE:
                return NEW if gained > 0 else BLOCKED
    return CALM
