"""Costs of a B-spline span, their minimiser, and the check of what came out.

A span is a run of control points (n, 2); its first and last three are fixed, so that the curve
joins what lies before and behind it in position, velocity and acceleration. Every cost adds its
gradient to `grad` (n, 2) and returns its value.
"""

from __future__ import annotations

import numpy as np
from numba import njit

FIXED = 3  # control points at each end of a span
_FLAT = 1e-6  # m², keeps eq. 16 smooth where neighbours coincide (at rest)
_MEMORY = 8  # pairs kept by L-BFGS
_ARMIJO = 1e-4
_HALVINGS = 12


@njit(cache=True, nogil=True)
def look_up(values, x0, y0, cell, outside, x, y):
    """Bilinear (distance, d/dx, d/dy) of a field whose cell [0, 0] has its corner at (x0, y0)."""
    nx, ny = values.shape
    gx = (x - x0) / cell - 0.5
    gy = (y - y0) / cell - 0.5
    if not (0.0 <= gx < nx - 1 and 0.0 <= gy < ny - 1):
        return outside, 0.0, 0.0
    i, j = int(gx), int(gy)
    fx, fy = gx - i, gy - j
    v00, v01 = values[i, j], values[i, j + 1]
    v10, v11 = values[i + 1, j], values[i + 1, j + 1]
    low = v00 + fx * (v10 - v00)
    high = v01 + fx * (v11 - v01)
    slope_x = ((1.0 - fy) * (v10 - v00) + fy * (v11 - v01)) / cell
    return low + fy * (high - low), slope_x, (high - low) / cell


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
def quasi_newton(grad, steps, changes, kept, newest, out):
    """The L-BFGS direction -H grad from `kept` pairs in a ring (Nocedal's two-loop recursion)."""
    alpha = np.empty(max(kept, 1))
    out[:] = -grad
    for back in range(kept):
        k = (newest - back) % steps.shape[0]
        alpha[back] = np.dot(steps[k], out) / np.dot(steps[k], changes[k])
        out -= alpha[back] * changes[k]
    if kept > 0:
        out *= np.dot(steps[newest], changes[newest]) / np.dot(changes[newest], changes[newest])
    for back in range(kept - 1, -1, -1):
        k = (newest - back) % steps.shape[0]
        beta = np.dot(changes[k], out) / np.dot(steps[k], changes[k])
        out += (alpha[back] - beta) * steps[k]


@njit(cache=True, nogil=True)
def minimise(q, guide, weights, limits, values, frame, iterations, tolerance):
    """L-BFGS with Armijo backtracking on the span's free points, in place.

    Stops when a step lowers the cost by less than `tolerance` of it. Returns (cost, iterations).
    """
    n = q.size
    flat = q.reshape(n)
    grad, trial_grad = np.zeros_like(q), np.zeros_like(q)
    trial = q.copy()
    steps, changes = np.empty((_MEMORY, n)), np.empty((_MEMORY, n))
    direction = np.empty(n)
    cost = span_cost(q, guide, weights, limits, values, frame, grad)
    kept, newest, small = 0, -1, 0
    for iteration in range(iterations):
        g = grad.reshape(n)
        quasi_newton(g, steps, changes, kept, newest, direction)
        slope = np.dot(g, direction)
        if slope > -1e-12:
            return cost, iteration
        longest = np.sqrt(np.dot(direction, direction))
        step = 1.0 if kept > 0 else min(1.0, 0.1 / longest)
        found = False
        for _ in range(_HALVINGS):
            trial.reshape(n)[:] = flat + step * direction
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
        s, y = trial.reshape(n) - flat, trial_grad.reshape(n) - g
        if np.dot(s, y) > 1e-10 * np.dot(s, s):
            newest = (newest + 1) % _MEMORY
            kept = min(kept + 1, _MEMORY)
            steps[newest], changes[newest] = s, y
        q[:], grad[:] = trial, trial_grad
        small = small + 1 if cost - lower < tolerance * cost else 0
        cost = lower
        if small >= 2:
            return cost, iteration + 1
    return cost, iterations


@njit(cache=True, nogil=True)
def inspect(q, interval, first, last, per_segment, values, frame, floor, slack, found):
    """Walk a trajectory (n, 3) from segment `first` (a float: part segments too) to `last`.

    A place is a conflict when its distance is under `floor`; a walk that begins under it may
    leave, but never come nearer than it was by more than `slack`. `found` receives: path length
    walked to the first conflict (inf: none), its segment (float), least distance, greatest speed,
    acceleration and turning rate of the tangent, and the path length walked.
    """
    found[0], found[1], found[2], found[3:] = np.inf, np.inf, np.inf, 0.0
    steps = int(np.ceil((last - first) * per_segment - 1e-9))
    reached = -np.inf
    px = py = pz = 0.0
    for s in range(steps + 1):
        phase = min(first + s / per_segment, last)
        k = min(max(int(phase), 0), q.shape[0] - 4)
        u = phase - k
        w = 1.0 - u
        b0, b1 = w * w * w / 6, (3 * u * u * u - 6 * u * u + 4) / 6
        b3 = u * u * u / 6
        b2 = 1.0 - b0 - b1 - b3
        d0, d1, d3 = -w * w / 2, (3 * u * u - 4 * u) / 2, u * u / 2
        d2 = -d0 - d1 - d3
        p, v, a = np.empty(3), np.empty(3), np.empty(3)
        for c in range(3):
            q0, q1, q2, q3 = q[k, c], q[k + 1, c], q[k + 2, c], q[k + 3, c]
            p[c] = b0 * q0 + b1 * q1 + b2 * q2 + b3 * q3
            v[c] = (d0 * q0 + d1 * q1 + d2 * q2 + d3 * q3) / interval
            a[c] = (w * (q0 - 2 * q1 + q2) + u * (q1 - 2 * q2 + q3)) / interval**2
        if s > 0:
            found[6] += np.sqrt((p[0] - px) ** 2 + (p[1] - py) ** 2 + (p[2] - pz) ** 2)
        px, py, pz = p[0], p[1], p[2]
        d = look_up(values, frame[0], frame[1], frame[2], frame[3], px, py)[0]
        found[2] = min(found[2], d)
        if found[0] == np.inf and d < (floor if reached >= floor else reached - slack):
            found[0], found[1] = found[6], phase
        reached = max(reached, d)
        speed = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        found[3] = max(found[3], speed)
        found[4] = max(found[4], np.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]))
        flat = v[0] * v[0] + v[1] * v[1]
        if flat > 0.04:  # a slower nose is turned by the yaw law, not by the tangent
            found[5] = max(found[5], abs(v[0] * a[1] - v[1] * a[0]) / flat)
