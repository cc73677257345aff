"""Rays against solids with a z-buffer, and the errors of a stereo camera.

Pixel (u, v) looks along `columns[:, u] + rows[v]`, a site-frame vector that reaches one metre
deep along the optical axis: the ray's parameter is the depth that the camera reports. Solids are
rows as in geometry/shapes.py; `windows` (n, 4) are the pixels u0, u1, v0, v1 that each may cover.
"""

from __future__ import annotations

import numpy as np
from numba import njit

NEAR = 0.02  # m: what is nearer is inside the lens
LEAF = 0.09  # m, size of the leaf clumps on a canopy
LEAF_DEPTH = 0.18  # m, how deep the gaps between them go
FLYING = 0.12  # share of the pixels at a depth edge that land between its two sides


@njit(cache=True, nogil=True, inline="always")
def _mixed(a, b, c, d):
    """A well-mixed 32-bit number of four integers: the same on any machine and thread."""
    h = (a * 0x9E3779B1) ^ (b * 0x85EBCA77) ^ (c * 0xC2B2AE3D) ^ (d * 0x27D4EB2F)
    h = np.uint64(h & 0xFFFFFFFF)
    h = ((h ^ (h >> np.uint64(15))) * np.uint64(0x2C1B3C6D)) & np.uint64(0xFFFFFFFF)
    h = ((h ^ (h >> np.uint64(12))) * np.uint64(0x297A2D39)) & np.uint64(0xFFFFFFFF)
    return np.int64(h ^ (h >> np.uint64(15)))


@njit(cache=True, nogil=True, inline="always")
def _gauss(h):
    """A number of mean 0 and deviation 1, nearly normal: the sum of a hash's four bytes."""
    total = (h & 255) + ((h >> 8) & 255) + ((h >> 16) & 255) + (h >> 24)
    return (np.float32(total) - np.float32(510.0)) * np.float32(1 / 147.80)


@njit(cache=True, nogil=True)
def draw_ground(columns, rows, plane, depth):
    """Fill with the depth of the ground z = plane[0] x + plane[1] y + plane[2], else infinity."""
    for v in range(depth.shape[0]):
        bx, by, bz = rows[v]
        for u in range(depth.shape[1]):
            x, y, z = columns[0, u] + bx, columns[1, u] + by, columns[2, u] + bz
            falling = plane[0] * x + plane[1] * y - z
            depth[v, u] = max(-plane[2] / falling, NEAR) if falling > 0 else np.inf


@njit(cache=True, nogil=True)
def draw_spheroids(columns, rows, windows, solids, origin, depth):
    """Canopies: the outer hull, broken into leaf clumps with gaps between them."""
    for n in range(solids.shape[0]):
        wide, tall = 1.0 / solids[n, 3], 1.0 / solids[n, 4]
        ox = (origin[0] - solids[n, 0]) * wide
        oy = (origin[1] - solids[n, 1]) * wide
        oz = (origin[2] - solids[n, 2]) * tall
        c = ox * ox + oy * oy + oz * oz - 1.0
        for v in range(windows[n, 2], windows[n, 3]):
            bx, by, bz = rows[v]
            for u in range(windows[n, 0], windows[n, 1]):
                x, y, z = columns[0, u] + bx, columns[1, u] + by, columns[2, u] + bz
                dx, dy, dz = x * wide, y * wide, z * tall
                a = dx * dx + dy * dy + dz * dz
                b = ox * dx + oy * dy + oz * dz
                h = b * b - a * c
                if h < 0.0:
                    continue
                h = np.sqrt(h)
                t = (-b - h) / a
                if t >= depth[v, u] or h - b <= NEAR * a:
                    continue
                t = max(t, NEAR)
                clump = _mixed(
                    int(np.floor((origin[0] + t * x) / LEAF)),
                    int(np.floor((origin[1] + t * y) / LEAF)),
                    int(np.floor((origin[2] + t * z) / LEAF)),
                    0,
                )
                t += LEAF_DEPTH * (clump >> 16) / 65536.0
                if t * a < h - b and t < depth[v, u]:
                    depth[v, u] = t


@njit(cache=True, nogil=True)
def draw_cylinders(columns, rows, windows, solids, origin, depth):
    """Trunks and poles: upright, with flat ends."""
    for n in range(solids.shape[0]):
        ox, oy, radius = solids[n, 0] - origin[0], solids[n, 1] - origin[1], solids[n, 4]
        bottom, top = solids[n, 2] - origin[2], solids[n, 3] - origin[2]
        c = ox * ox + oy * oy - radius * radius
        for v in range(windows[n, 2], windows[n, 3]):
            bx, by, bz = rows[v]
            for u in range(windows[n, 0], windows[n, 1]):
                x, y, z = columns[0, u] + bx, columns[1, u] + by, columns[2, u] + bz
                a = x * x + y * y
                b = ox * x + oy * y
                h = b * b - a * c
                if h < 0.0 or a == 0.0:
                    continue
                t = (b - np.sqrt(h)) / a
                height = t * z
                if height < bottom or height > top:  # past the rim: perhaps onto an end
                    if z == 0.0:
                        continue
                    t = (top if height > top else bottom) / z
                    if (t * x - ox) ** 2 + (t * y - oy) ** 2 > radius * radius:
                        continue
                if NEAR < t < depth[v, u]:
                    depth[v, u] = t


@njit(cache=True, nogil=True)
def draw_capsules(columns, rows, windows, solids, origin, depth):
    """Pieces of wire, and people."""
    for n in range(solids.shape[0]):
        ax, ay, az = solids[n, 0] - origin[0], solids[n, 1] - origin[1], solids[n, 2] - origin[2]
        lx, ly, lz = (
            solids[n, 3] - solids[n, 0],
            solids[n, 4] - solids[n, 1],
            solids[n, 5] - solids[n, 2],
        )
        ex, ey, ez = ax + lx, ay + ly, az + lz
        ll = lx * lx + ly * ly + lz * lz
        la = -(lx * ax + ly * ay + lz * az)
        aa = ax * ax + ay * ay + az * az
        ee = ex * ex + ey * ey + ez * ez
        rr = solids[n, 6] * solids[n, 6]
        for v in range(windows[n, 2], windows[n, 3]):
            bx, by, bz = rows[v]
            for u in range(windows[n, 0], windows[n, 1]):
                x, y, z = columns[0, u] + bx, columns[1, u] + by, columns[2, u] + bz
                dd = x * x + y * y + z * z
                ld = lx * x + ly * y + lz * z
                da = -(x * ax + y * ay + z * az)
                a = ll * dd - ld * ld
                b = ll * da - la * ld
                h = b * b - a * (ll * (aa - rr) - la * la)
                if h < 0.0:
                    continue
                t = (-b - np.sqrt(h)) / a if a > 1e-12 else 0.0
                along = la + t * ld
                if a <= 1e-12 or along < 0.0 or along > ll:  # an end: a ball
                    first = along < 0.0 or (a <= 1e-12 and ld > 0.0)
                    b = da if first else -(x * ex + y * ey + z * ez)
                    h = b * b - dd * ((aa if first else ee) - rr)
                    if h < 0.0:
                        continue
                    t = (-b - np.sqrt(h)) / dd
                if NEAR < t < depth[v, u]:
                    depth[v, u] = t


@njit(cache=True, nogil=True)
def draw_boxes(columns, rows, windows, solids, origin, depth):
    """Boxes turned about their upright axis."""
    for n in range(solids.shape[0]):
        gx, gy, oz = origin[0] - solids[n, 0], origin[1] - solids[n, 1], origin[2] - solids[n, 2]
        ex, ey, ez = solids[n, 3], solids[n, 4], solids[n, 5]
        cos, sin = np.cos(solids[n, 6]), np.sin(solids[n, 6])
        ox, oy = cos * gx + sin * gy, cos * gy - sin * gx
        for v in range(windows[n, 2], windows[n, 3]):
            bx, by, bz = rows[v]
            for u in range(windows[n, 0], windows[n, 1]):
                x, y, z = columns[0, u] + bx, columns[1, u] + by, columns[2, u] + bz
                enter, leave = NEAR, float(depth[v, u])
                for o, d, e in (
                    (ox, cos * x + sin * y, ex),
                    (oy, cos * y - sin * x, ey),
                    (oz, z, ez),
                ):
                    if abs(d) > 1e-12:
                        t0, t1 = (-e - o) / d, (e - o) / d
                        enter, leave = max(enter, min(t0, t1)), min(leave, max(t0, t1))
                    elif abs(o) > e:
                        leave = NEAR
                if NEAR < enter < leave and enter < depth[v, u]:
                    depth[v, u] = enter


@njit(cache=True, nogil=True)
def sense(depth, focal_baseline, sigma, dropout, near, far, seed, frame, out):
    """What a stereo pair makes of true depths (h, w) m: `out` (h, w) uint16 mm, 0 for no return.

    Disparity is focal_baseline / depth (px). Seen from the right-hand imager, what lies to the
    left of a nearer thing is hidden: holes. Some pixels at such edges fly between the two sides.
    The error is half each pixel's own, half shared by blocks of 4x4, as matching windows
    overlap; then disparity is quantised to 1/32 px.
    """
    own, shared = np.float32(0.7071 * sigma), np.float32(0.7071 * sigma)
    width = depth.shape[1]
    for v in range(depth.shape[0]):
        hidden_from = np.float32(np.inf)  # nearest right-image column taken by the pixels so far
        right = np.float32(0.0)  # disparity of the right-hand neighbour
        for step in range(width):
            u = width - 1 - step
            z = depth[v, u]
            d = np.float32(focal_baseline) / z  # 0 for infinity
            place = np.float32(u) - d
            hidden = place >= hidden_from
            hidden_from = min(hidden_from, place)
            edge = abs(d - right) > np.float32(1.0) and step > 0
            beside, right = right, d
            h = _mixed(u, v, frame, seed)
            if edge and (h & 1023) < 1024 * FLYING:
                d += (beside - d) * np.float32((h >> 10) & 1023) / np.float32(1024)
            elif hidden:
                out[v, u] = 0
                continue
            chance = _mixed(v, u, seed, frame)
            if not d > 0 or (chance >> 8) < dropout * 16777216.0:
                out[v, u] = 0
                continue
            d += own * _gauss(h) + shared * _gauss(_mixed(u >> 2, v >> 2, frame, ~seed))
            d = np.float32(np.round(d * np.float32(32))) / np.float32(32)
            z = np.float32(focal_baseline) / d if d > 0 else np.float32(np.inf)
            out[v, u] = np.uint16(z * np.float32(1000) + np.float32(0.5)) if near <= z <= far else 0
