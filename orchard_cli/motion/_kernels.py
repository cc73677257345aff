"""Looking up a distance field, and walking along a trajectory through it."""

from __future__ import annotations

import numpy as np
from numba import njit


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
        if flat > 0.25:  # slower, the nose may lag: the way to a halt is within what it has seen
            found[5] = max(found[5], abs(v[0] * a[1] - v[1] * a[0]) / flat)


@njit(cache=True, nogil=True)
def looked(q, interval, first, last, observed, origin, cell, eye, gap):
    """Path length, m, from segment `first` (a float) to the first stretch not looked at yet.

    Looked at is a place that `observed` (nx, ny) says was seen, or that lies in the camera's view
    now. eye: x, y, cos and sin of the nose's yaw, range m, half width per depth. Stretches of less
    than `gap` m do not count. inf when all was looked at.
    """
    nx, ny = observed.shape
    steps = max(int(np.ceil((last - first) * interval / 0.0625)), 1)
    length, seen_to = 0.0, 0.0
    px = py = 0.0
    for s in range(steps):
        phase = first + (last - first) * s / steps
        k = min(max(int(phase), 0), q.shape[0] - 4)
        u = phase - k
        w = 1.0 - u
        b0, b1 = w * w * w / 6, (3 * u * u * u - 6 * u * u + 4) / 6
        b3 = u * u * u / 6
        b2 = 1.0 - b0 - b1 - b3
        x = b0 * q[k, 0] + b1 * q[k + 1, 0] + b2 * q[k + 2, 0] + b3 * q[k + 3, 0]
        y = b0 * q[k, 1] + b1 * q[k + 1, 1] + b2 * q[k + 2, 1] + b3 * q[k + 3, 1]
        if s > 0:
            length += np.sqrt((x - px) ** 2 + (y - py) ** 2)
        px, py = x, y
        i = min(max(int(np.floor((x - origin[0]) / cell)), 0), nx - 1)
        j = min(max(int(np.floor((y - origin[1]) / cell)), 0), ny - 1)
        dx, dy = x - eye[0], y - eye[1]
        depth, side = dx * eye[2] + dy * eye[3], abs(dy * eye[2] - dx * eye[3])
        if observed[i, j] or (depth < eye[4] and side <= depth * eye[5]):
            seen_to = length
        elif length - seen_to >= gap:
            return seen_to
    return np.inf


@njit(cache=True, nogil=True)
def free_again(knots, begin, values, frame, floor, out):
    """How much of a reference is free around each of its knots.

    knots (n, 2 or 3) m; those before `begin` count as free. out (n, 5): path length, whether the
    knot keeps `floor` (1 or 0), free metres behind it (from `begin` at the earliest) and before it,
    and the angle by which the way has turned since `begin`, rad.
    """
    n = knots.shape[0]
    way, turned = np.nan, 0.0
    for i in range(n):
        step, dx, dy = 0.0, 0.0, 0.0
        if i > 0:
            dx, dy = knots[i, 0] - knots[i - 1, 0], knots[i, 1] - knots[i - 1, 1]
            step = out[i - 1, 0] + np.sqrt(dx * dx + dy * dy)
        out[i, 0] = step
        d = look_up(values, frame[0], frame[1], frame[2], frame[3], knots[i, 0], knots[i, 1])[0]
        out[i, 1] = 1.0 if d >= floor else 0.0
        if i > begin and step > out[i - 1, 0] + 1e-6:
            heading = np.arctan2(dy, dx)
            if not np.isnan(way):
                turn = abs(heading - way)
                turned += min(turn, 2 * np.pi - turn)
            way = heading
        out[i, 4] = turned
    last = out[begin, 0]
    for i in range(n):
        if i <= begin:
            out[i, 2] = 0.0
            continue
        if out[i, 1] == 0.0:
            last = out[i, 0]
        out[i, 2] = out[i, 0] - last
    nearest = np.inf
    for i in range(n - 1, -1, -1):
        if out[i, 1] == 0.0:
            nearest = out[i, 0]
        out[i, 3] = nearest - out[i, 0]
