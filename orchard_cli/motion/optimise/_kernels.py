"""Costs of a B-spline span and their minimiser.

A span is a run of control points (n, 2); its first and last three are fixed, so that the curve
joins what lies before and behind it in position, velocity and acceleration. Every cost adds its
gradient to `grad` (n, 2) and returns its value.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from orchard_cli.motion._kernels import look_up

FIXED = 3  # control points at each end of a span
_FLAT = 1e-6  # m², keeps eq. 16 smooth where neighbours coincide (at rest)
_MEMORY = 8  # pairs kept by L-BFGS
_GROUND = 0.03  # added stiffness of each point, so that no first step is wild
_ARMIJO = 1e-4
_HALVINGS = 12


@njit(cache=True, nogil=True)
def smoothness(q, weight, grad):
    """Squared distance of each point to the line through its neighbours (Liu 2024, eq. 16)."""
    total = 0.0
    for i in range(1, q.shape[0] - 1):
        lx, ly = q[i + 1, 0] - q[i - 1, 0], q[i + 1, 1] - q[i - 1, 1]
        ex, ey = q[i, 0] - q[i - 1, 0], q[i, 1] - q[i - 1, 1]
        cross = lx * ey - ly * ex
        square = lx * lx + ly * ly + _FLAT
        total += cross * cross / square
        along, shrink = 2 * weight * cross / square, 2 * weight * cross * cross / square**2
        dlx, dly = along * ey - shrink * lx, -along * ex - shrink * ly
        dex, dey = -along * ly, along * lx
        grad[i + 1, 0] += dlx
        grad[i + 1, 1] += dly
        grad[i, 0] += dex
        grad[i, 1] += dey
        grad[i - 1, 0] -= dlx + dex
        grad[i - 1, 1] -= dly + dey
    return weight * total


@njit(cache=True, nogil=True)
def jerk(q, weight, grad):
    """Squared third differences: the even spacing that eq. 16 leaves open (Zhou 2020)."""
    total = 0.0
    for i in range(q.shape[0] - 3):
        for c in range(2):
            j = q[i + 3, c] - 3 * q[i + 2, c] + 3 * q[i + 1, c] - q[i, c]
            total += j * j
            pull = 2 * weight * j
            grad[i + 3, c] += pull
            grad[i + 2, c] -= 3 * pull
            grad[i + 1, c] += 3 * pull
            grad[i, c] -= pull
    return weight * total


@njit(cache=True, nogil=True)
def guidance(q, guide, weight, grad):
    """Squared distance of each point to its own point of the guide path (Liu 2024, eq. 17)."""
    total = 0.0
    for i in range(FIXED, q.shape[0] - FIXED):
        for c in range(2):
            off = q[i, c] - guide[i, c]
            total += off * off
            grad[i, c] += 2 * weight * off
    return weight * total


@njit(cache=True, nogil=True)
def collision(q, values, x0, y0, cell, outside, threshold, soft, weight, grad):
    """Liu 2024, eqs. 19-20, rounded off within `soft` metres of the threshold.

    Eq. 20 is 2 |d - d_thr| inside the threshold: its slope jumps from 0 to 2 where most optima
    lie. Here it rises as x² / soft first and continues with slope 2, so it is C1.
    """
    total = 0.0
    for i in range(FIXED, q.shape[0] - FIXED):
        d, dx, dy = look_up(values, x0, y0, cell, outside, q[i, 0], q[i, 1])
        x = threshold - d
        if x <= 0.0:
            continue
        rounded = x < soft
        total += x * x / soft if rounded else 2 * x - soft
        pull = weight * (2 * x / soft if rounded else 2.0)
        grad[i, 0] -= pull * dx
        grad[i, 1] -= pull * dy
    return weight * total


@njit(cache=True, nogil=True)
def speeding(q, interval, limit, weight, grad):
    """Squared excess of the velocity control points (Liu 2024, eqs. 21, 22, 24), of their norm.

    The paper counts each axis alone; the norm is what the vehicle's limit means and does not
    depend on how the rows lie to the axes.
    """
    total = 0.0
    for i in range(q.shape[0] - 1):
        vx, vy = (q[i + 1, 0] - q[i, 0]) / interval, (q[i + 1, 1] - q[i, 1]) / interval
        speed = np.sqrt(vx * vx + vy * vy)
        excess = speed - limit
        if excess <= 0.0:
            continue
        total += excess * excess
        pull = 2 * weight * excess / (speed * interval)
        grad[i + 1, 0] += pull * vx
        grad[i + 1, 1] += pull * vy
        grad[i, 0] -= pull * vx
        grad[i, 1] -= pull * vy
    return weight * total


@njit(cache=True, nogil=True)
def straining(q, interval, limit, weight, grad):
    """Squared excess of the acceleration control points (Liu 2024, eqs. 21, 23, 25), of norms."""
    total = 0.0
    square = interval * interval
    for i in range(q.shape[0] - 2):
        ax = (q[i + 2, 0] - 2 * q[i + 1, 0] + q[i, 0]) / square
        ay = (q[i + 2, 1] - 2 * q[i + 1, 1] + q[i, 1]) / square
        size = np.sqrt(ax * ax + ay * ay)
        excess = size - limit
        if excess <= 0.0:
            continue
        total += excess * excess
        pull = 2 * weight * excess / (size * square)
        for c, a in ((0, ax), (1, ay)):
            grad[i + 2, c] += pull * a
            grad[i + 1, c] -= 2 * pull * a
            grad[i, c] += pull * a
    return weight * total


@njit(cache=True, nogil=True)
def span_cost(q, guide, weights, limits, values, frame, grad):
    """The whole cost of a span and its gradient, which is 0 at the fixed points.

    weights: smooth, jerk, guide, collision, feasible. limits: interval s, speed, acceleration,
    distance threshold m, softness m. frame: x0, y0, cell, outside of the field.
    """
    grad[:] = 0.0
    total = smoothness(q, weights[0], grad)
    if weights[1] > 0:
        total += jerk(q, weights[1], grad)
    if weights[2] > 0:
        total += guidance(q, guide, weights[2], grad)
    if weights[3] > 0:
        total += collision(
            q, values, frame[0], frame[1], frame[2], frame[3], limits[3], limits[4],
            weights[3], grad,
        )  # fmt: skip
    if weights[4] > 0:
        total += speeding(q, limits[0], limits[1], weights[4], grad)
        total += straining(q, limits[0], limits[2], weights[4], grad)
    grad[:FIXED] = 0.0
    grad[q.shape[0] - FIXED :] = 0.0
    return total


@njit(cache=True, nogil=True)
def stiffness(weights, band):
    """Cholesky factor of the smoothness terms' Hessian over f free points, in `band` (f, 4).

    Both coordinates share it. Eq. 16's is taken at an even spacing, half along the path.
    """
    f = band.shape[0]
    band[:] = 0.0
    second, third = np.array([1.0, -2.0, 1.0, 0.0]), np.array([-1.0, 3.0, -3.0, 1.0])
    for stencil, size, scale in ((second, 3, 0.25 * weights[0]), (third, 4, 2.0 * weights[1])):
        for row in range(-3, f):
            for i in range(size):
                for j in range(i + 1):
                    if row + j >= 0 and row + i < f:
                        band[row + i, i - j] += scale * stencil[i] * stencil[j]
    for i in range(f):
        band[i, 0] += 2.0 * weights[2] + _GROUND
        for k in range(min(i, 3), -1, -1):
            j = i - k
            total = band[i, k]
            for m in range(max(i - 3, 0), j):
                total -= band[i, i - m] * band[j, j - m]
            band[i, k] = total / band[j, 0] if k > 0 else np.sqrt(total)


@njit(cache=True, nogil=True)
def soften(band, x):
    """Solve the factored band for both columns of x (f, 2), in place."""
    f = band.shape[0]
    for c in range(2):
        for i in range(f):
            for k in range(1, min(i, 3) + 1):
                x[i, c] -= band[i, k] * x[i - k, c]
            x[i, c] /= band[i, 0]
        for i in range(f - 1, -1, -1):
            for k in range(1, min(f - 1 - i, 3) + 1):
                x[i, c] -= band[i + k, k] * x[i + k, c]
            x[i, c] /= band[i, 0]


@njit(cache=True, nogil=True)
def _inner(a, b):
    total = 0.0
    for i in range(a.shape[0]):
        total += a[i, 0] * b[i, 0] + a[i, 1] * b[i, 1]
    return total


@njit(cache=True, nogil=True)
def _add(a, factor, b):
    for i in range(a.shape[0]):
        a[i, 0] += factor * b[i, 0]
        a[i, 1] += factor * b[i, 1]


@njit(cache=True, nogil=True)
def quasi_newton(grad, steps, changes, kept, newest, band, out):
    """The L-BFGS direction -H grad from `kept` pairs in a ring (Nocedal's two-loop recursion).

    H starts from the inverse of the smoothness terms' Hessian rather than a multiple of one, so
    that a long smooth move of many points takes one iteration and not fifty.
    """
    alpha, inverse = np.empty(_MEMORY), np.empty(_MEMORY)
    for i in range(grad.shape[0]):
        out[i, 0], out[i, 1] = -grad[i, 0], -grad[i, 1]
    for back in range(kept):
        k = (newest - back) % _MEMORY
        inverse[back] = 1.0 / _inner(steps[k], changes[k])
        alpha[back] = _inner(steps[k], out) * inverse[back]
        _add(out, -alpha[back], changes[k])
    soften(band, out)
    for back in range(kept - 1, -1, -1):
        k = (newest - back) % _MEMORY
        _add(out, alpha[back] - _inner(changes[k], out) * inverse[back], steps[k])


@njit(cache=True, nogil=True)
def minimise(q, guide, weights, limits, values, frame, iterations, tolerance):
    """L-BFGS with Armijo backtracking on the span's free points, in place.

    Stops after two steps that lower the cost by less than `tolerance` of it. Returns (cost,
    iterations).
    """
    n = q.shape[0]
    grad, trial_grad = np.zeros((n, 2)), np.zeros((n, 2))
    trial = q.copy()
    f = n - 2 * FIXED
    steps, changes = np.empty((_MEMORY, f, 2)), np.empty((_MEMORY, f, 2))
    direction, band = np.empty((f, 2)), np.empty((f, 4))
    stiffness(weights, band)
    slope_of = grad[FIXED : n - FIXED]
    cost = span_cost(q, guide, weights, limits, values, frame, grad)
    kept, newest, small = 0, -1, 0
    for iteration in range(iterations):
        quasi_newton(slope_of, steps, changes, kept, newest, band, direction)
        slope = _inner(slope_of, direction)
        if slope > -1e-12:
            return cost, iteration
        step = 1.0
        found = False
        for _ in range(_HALVINGS):
            _place(trial, q, step, direction)
            lower = span_cost(trial, guide, weights, limits, values, frame, trial_grad)
            if lower <= cost + _ARMIJO * step * slope:
                found = True
                break
            step *= 0.5
        if not found:
            if kept == 0:
                return cost, iteration
            kept = 0  # a kink of the field spoilt the memory: start again downhill
            continue
        ring = (newest + 1) % _MEMORY
        for i in range(f):
            for c in range(2):
                steps[ring, i, c] = step * direction[i, c]
                changes[ring, i, c] = trial_grad[FIXED + i, c] - grad[FIXED + i, c]
        if _inner(steps[ring], changes[ring]) > 1e-10 * _inner(steps[ring], steps[ring]):
            newest, kept = ring, min(kept + 1, _MEMORY)
        q[:], grad[:] = trial, trial_grad
        small = small + 1 if cost - lower < tolerance * cost else 0
        cost = lower
        if small >= 2:
            return cost, iteration + 1
    return cost, iterations


@njit(cache=True, nogil=True)
def _place(trial, q, step, direction):
    for i in range(direction.shape[0]):
        for c in range(2):
            trial[FIXED + i, c] = q[FIXED + i, c] + step * direction[i, c]
