"""Rays against solids with a z-buffer, and the errors of a stereo camera.

Pixel (u, v) looks along `columns[:, u] + rows[v]`, a site-frame vector that reaches one metre
deep along the optical axis: the ray's parameter t is the depth that the camera reports. The image
is kept as `nearness` 1 / t (1/m, 0: nothing): disparity is in proportion to it, over a plane it
is linear in u, and where t is the nearer root of a t² + 2 b t + c = 0, with the lens outside, it
needs no division by a: 1 / t = (sqrt(b² - a c) - b) / c.

Solids are rows as in geometry/shapes.py; `windows` (n, 4) are the pixels u0, u1, v0, v1 that each
may cover. Everything runs along a row of pixels in single precision and without branches, so that
the compiler works on eight pixels at a time; a square root's small difference of large numbers is
taken as a cross product instead (Lagrange), which a wire of 10 mm needs.
"""

from __future__ import annotations

import numpy as np
from numba import njit

NEAR = 0.02  # m: what is nearer is inside the lens
LEAF = 0.09  # m, size of the leaf clumps on a canopy
LEAF_DEPTH = 0.18  # m, how deep the gaps between them go
FLYING = 0.12  # share of the pixels at a depth edge that land between its two sides

_NOTHING, _NEAREST, _FARTHEST = np.float32(0), np.float32(1 / NEAR), np.float32(60)
_PER_LEAF, _GAP = np.float32(1 / LEAF), np.float32(LEAF_DEPTH / 65536)
_HALF, _STEPS, _STEP = np.float32(0.5), np.float32(32), np.float32(1 / 32)


@njit(cache=True, nogil=True)
def _mixed(h):
    """A well-mixed 32-bit number of another (C. Wellons, lowbias32): the same on any machine."""
    h = np.uint32(h ^ (h >> np.uint32(16)))
    h = np.uint32(h * np.uint32(0x7FEB352D))
    h = np.uint32(h ^ (h >> np.uint32(15)))
    h = np.uint32(h * np.uint32(0x846CA68B))
    return np.uint32(h ^ (h >> np.uint32(16)))


@njit(cache=True, nogil=True)
def _key(a, b, c):
    """One 32-bit number of three."""
    h = _mixed(np.uint32(a))
    h = _mixed(np.uint32(h ^ np.uint32(b)))
    return _mixed(np.uint32(h ^ np.uint32(c)))


@njit(cache=True, nogil=True)
def _fill(key, shift, out):
    """`out` (n,) uint32: mixed numbers, each for 2**shift neighbours."""
    for u in range(out.size):
        out[u] = _mixed(np.uint32(np.uint32(key) + np.uint32(u >> shift)))


@njit(cache=True, nogil=True)
def _gauss(h):
    """A number of mean 0 and deviation 1, nearly normal: the sum of a hash's four bytes."""
    low = np.uint32(h & np.uint32(0x00FF00FF)) + np.uint32(
        (h >> np.uint32(8)) & np.uint32(0xFF00FF)
    )
    total = np.int32((low & np.uint32(0xFFFF)) + (low >> np.uint32(16)))
    return (np.float32(total) - np.float32(510)) * np.float32(1 / 147.80)


@njit(cache=True, nogil=True)
def find_windows(low, high, origin, site_from_camera, intrinsics, size, farthest, windows):
    """The pixels u0, u1, v0, v1 that the box from `low[n]` to `high[n]` may cover, empty if none.

    `intrinsics` fx, fy, cx, cy; `size` (width, height). Boxes are cut at the near plane: what lies
    behind the camera covers nothing. A box that is nowhere nearer than `farthest` is left out.
    """
    r = site_from_camera
    corner = np.empty((8, 3))
    for n in range(low.shape[0]):
        nearest = np.inf
        for k in range(8):
            x = (high[n, 0] if k & 1 else low[n, 0]) - origin[0]
            y = (high[n, 1] if k & 2 else low[n, 1]) - origin[1]
            z = (high[n, 2] if k & 4 else low[n, 2]) - origin[2]
            for i in range(3):
                corner[k, i] = r[0, i] * x + r[1, i] * y + r[2, i] * z
            nearest = min(nearest, corner[k, 2])
        windows[n] = 0
        if nearest >= farthest:
            continue
        left, right, top, bottom = np.inf, -np.inf, np.inf, -np.inf
        for k in range(8):
            for other in (k, k ^ 1, k ^ 2, k ^ 4):  # the corner, and its edges' cuts
                a, b = corner[k], corner[other]
                if a[2] < NEAR or (other != k and b[2] >= NEAR):
                    continue
                share = (a[2] - NEAR) / (a[2] - b[2]) if other != k else 0.0
                z = a[2] + share * (b[2] - a[2])
                u = intrinsics[0] * (a[0] + share * (b[0] - a[0])) / z + intrinsics[2]
                v = intrinsics[1] * (a[1] + share * (b[1] - a[1])) / z + intrinsics[3]
                left, right = min(left, u), max(right, u)
                top, bottom = min(top, v), max(bottom, v)
        if left < size[0] and right >= 0 and top < size[1] and bottom >= 0:
            windows[n, 0], windows[n, 1] = max(np.ceil(left), 0), min(np.floor(right) + 1, size[0])
            windows[n, 2], windows[n, 3] = max(np.ceil(top), 0), min(np.floor(bottom) + 1, size[1])


@njit(cache=True, nogil=True, error_model="numpy")
def draw_ground(columns, rows, plane, nearness):
    """Fill with the ground z = plane[0] x + plane[1] y + plane[2], seen from the origin."""
    above = np.float32(1 / max(-plane[2], NEAR * NEAR))
    a, b = np.float32(plane[0]), np.float32(plane[1])
    for v in range(nearness.shape[0]):
        falling = (a * rows[v, 0] + b * rows[v, 1] - rows[v, 2]) * above
        row = nearness[v]
        for u in range(row.size):
            tilt = (a * columns[0, u] + b * columns[1, u] - columns[2, u]) * above
            row[u] = min(max(falling + tilt, _NOTHING), _NEAREST)


@njit(cache=True, nogil=True)
def _positive(first, half, last, start, stop):
    """Where first + 2 half u + last u² is not negative within [start, stop): the whole numbers."""
    if last >= 0:
        return start, stop
    h = half * half - first * last
    if h < 0:
        return start, start
    middle, reach = -half / last, -np.sqrt(h) / last
    begin = int(min(max(np.ceil(middle - reach), start), stop))
    return begin, int(max(min(np.floor(middle + reach) + 1, stop), begin))


@njit(cache=True, nogil=True, error_model="numpy")
def draw_spheroids(columns, rows, windows, solids, origin, nearness):
    """Canopies: the outer hull, broken into leaf clumps with gaps between them."""
    px, py, pz = np.float32(origin[0]), np.float32(origin[1]), np.float32(origin[2])
    for n in range(solids.shape[0]):
        wide, tall = np.float32(1 / solids[n, 3]), np.float32(1 / solids[n, 4])
        ox = np.float32((origin[0] - solids[n, 0]) / solids[n, 3])
        oy = np.float32((origin[1] - solids[n, 1]) / solids[n, 3])
        oz = np.float32((origin[2] - solids[n, 2]) / solids[n, 4])
        c = ox * ox + oy * oy + oz * oz - np.float32(1)
        if c <= 0:  # the lens is among the leaves
            nearness[:] = _NEAREST
            return
        per_c = np.float32(1) / c
        last = columns.shape[1] - 1
        ex = np.float64(columns[0, last] - columns[0, 0]) / max(last, 1) * wide  # to the next pixel
        ey = np.float64(columns[1, last] - columns[1, 0]) / max(last, 1) * wide
        ez = np.float64(columns[2, last] - columns[2, 0]) / max(last, 1) * tall
        oe, ee = ox * ex + oy * ey + oz * ez, ex * ex + ey * ey + ez * ez
        for v in range(windows[n, 2], windows[n, 3]):
            bx, by, bz = rows[v, 0], rows[v, 1], rows[v, 2]
            gx, gy = np.float64(columns[0, 0] + bx) * wide, np.float64(columns[1, 0] + by) * wide
            gz = np.float64(columns[2, 0] + bz) * tall
            og, gg = ox * gx + oy * gy + oz * gz, gx * gx + gy * gy + gz * gz
            ge = gx * ex + gy * ey + gz * ez
            u0, u1 = _positive(
                og * og - c * gg, og * oe - c * ge, oe * oe - c * ee, windows[n, 0], windows[n, 1]
            )
            row = nearness[v, u0:u1]
            cx, cy, cz = columns[0, u0:u1], columns[1, u0:u1], columns[2, u0:u1]
            for u in range(row.size):
                x, y, z = cx[u] + bx, cy[u] + by, cz[u] + bz
                dx, dy, dz = x * wide, y * wide, z * tall
                a = dx * dx + dy * dy + dz * dz
                b = ox * dx + oy * dy + oz * dz
                h = b * b - a * c
                root = np.sqrt(max(h, _NOTHING))
                enter, leave = (root - b) * per_c, (-root - b) * per_c
                t = np.float32(1) / min(max(enter, np.float32(1e-3)), _NEAREST)
                clump = np.uint32(np.int32(np.floor((px + t * x) * _PER_LEAF))) * np.uint32(
                    0x9E3779B1
                )
                clump ^= np.uint32(np.int32(np.floor((py + t * y) * _PER_LEAF))) * np.uint32(
                    0x85EBCA77
                )
                clump ^= np.uint32(np.int32(np.floor((pz + t * z) * _PER_LEAF))) * np.uint32(
                    0xC2B2AE3D
                )
                gap = _GAP * np.float32(np.int32(_mixed(np.uint32(clump)) >> np.uint32(16)))
                leaf = np.float32(1) / (t + gap)
                seen = (h >= 0) & (enter > 0) & (leaf > leave) & (leaf > row[u])
                row[u] = leaf if seen else row[u]


@njit(cache=True, nogil=True, error_model="numpy")
def draw_cylinders(columns, rows, windows, solids, origin, nearness):
    """Trunks and poles: upright, with flat ends."""
    for n in range(solids.shape[0]):
        ox, oy = np.float32(solids[n, 0] - origin[0]), np.float32(solids[n, 1] - origin[1])
        bottom, top = np.float32(solids[n, 2] - origin[2]), np.float32(solids[n, 3] - origin[2])
        rr = np.float32(solids[n, 4] ** 2)
        c = ox * ox + oy * oy - rr
        per_c = np.float32(1) / c if c > 0 else _NOTHING
        per_end = _NOTHING  # of the end that is seen, if any
        if bottom > 0 or top < 0:
            per_end = np.float32(1) / (bottom if bottom > 0 else top)
        u0, u1 = windows[n, 0], windows[n, 1]
        cx, cy, cz = columns[0, u0:u1], columns[1, u0:u1], columns[2, u0:u1]
        for v in range(windows[n, 2], windows[n, 3]):
            bx, by, bz = rows[v, 0], rows[v, 1], rows[v, 2]
            row = nearness[v, u0:u1]
            for u in range(row.size):
                x, y, z = cx[u] + bx, cy[u] + by, cz[u] + bz
                cross = ox * y - oy * x
                h = rr * (x * x + y * y) - cross * cross
                side = (ox * x + oy * y + np.sqrt(max(h, _NOTHING))) * per_c
                on_side = (h >= 0) & (z >= bottom * side) & (z <= top * side)
                flat = z * per_end
                fx, fy = x - ox * flat, y - oy * flat
                on_flat = fx * fx + fy * fy <= rr * flat * flat
                near = side if on_side else flat if on_flat else _NOTHING
                row[u] = near if (near > row[u]) & (near < _NEAREST) else row[u]


@njit(cache=True, nogil=True)
def _ball(x, y, z, ax, ay, az, rr, per_c):
    """Nearness of a ball around a: 0 or less where the ray misses it."""
    mx, my, mz = ay * z - az * y, az * x - ax * z, ax * y - ay * x
    h = rr * (x * x + y * y + z * z) - (mx * mx + my * my + mz * mz)
    near = (x * ax + y * ay + z * az + np.sqrt(max(h, _NOTHING))) * per_c
    return near if h >= 0 else _NOTHING


@njit(cache=True, nogil=True, error_model="numpy")
def draw_capsules(columns, rows, windows, solids, origin, nearness):
    """Pieces of wire, and people: the nearest of a round side and the balls at both ends."""
    one = np.float32(1)
    for n in range(solids.shape[0]):
        a = (solids[n, 0:3] - origin).astype(np.float32)
        e = (solids[n, 3:6] - origin).astype(np.float32)
        ax, ay, az, ex, ey, ez = a[0], a[1], a[2], e[0], e[1], e[2]
        lx, ly, lz = ex - ax, ey - ay, ez - az
        rr = np.float32(solids[n, 6] ** 2)
        ll, la = lx * lx + ly * ly + lz * lz, lx * ax + ly * ay + lz * az
        qx, qy, qz = ly * az - lz * ay, lz * ax - lx * az, lx * ay - ly * ax
        sc = qx * qx + qy * qy + qz * qz - ll * rr
        ac, ec = ax * ax + ay * ay + az * az - rr, ex * ex + ey * ey + ez * ez - rr
        per_side = one / sc if sc > 0 else _NOTHING
        per_a = one / ac if ac > 0 else _NOTHING
        per_e = one / ec if ec > 0 else _NOTHING
        u0, u1 = windows[n, 0], windows[n, 1]
        cx, cy, cz = columns[0, u0:u1], columns[1, u0:u1], columns[2, u0:u1]
        for v in range(windows[n, 2], windows[n, 3]):
            bx, by, bz = rows[v, 0], rows[v, 1], rows[v, 2]
            row = nearness[v, u0:u1]
            for u in range(row.size):
                x, y, z = cx[u] + bx, cy[u] + by, cz[u] + bz
                nx, ny, nz = ly * z - lz * y, lz * x - lx * z, lx * y - ly * x
                away = qx * x + qy * y + qz * z
                h = rr * (nx * nx + ny * ny + nz * nz) - away * away
                side = (qx * nx + qy * ny + qz * nz + np.sqrt(max(ll * h, _NOTHING))) * per_side
                along = lx * x + ly * y + lz * z - la * side
                on_side = (h >= 0) & (along >= 0) & (along <= ll * side)
                near = max(
                    side if on_side else _NOTHING,
                    _ball(x, y, z, ax, ay, az, rr, per_a),
                    _ball(x, y, z, ex, ey, ez, rr, per_e),
                )
                row[u] = near if (near > row[u]) & (near < _NEAREST) else row[u]


@njit(cache=True, nogil=True)
def _slab(o, d, e):
    """Where a ray from o along d is between -e and e: the parameters of both ends."""
    d = d if abs(d) > np.float32(1e-9) else np.float32(1e-9)
    first, last = (-e - o) / d, (e - o) / d
    return min(first, last), max(first, last)


@njit(cache=True, nogil=True, error_model="numpy")
def draw_boxes(columns, rows, windows, solids, origin, nearness):
    """Boxes turned about their upright axis."""
    for n in range(solids.shape[0]):
        gx, gy = origin[0] - solids[n, 0], origin[1] - solids[n, 1]
        cos, sin = np.float32(np.cos(solids[n, 6])), np.float32(np.sin(solids[n, 6]))
        ox, oy = np.float32(cos * gx + sin * gy), np.float32(cos * gy - sin * gx)
        oz = np.float32(origin[2] - solids[n, 2])
        ex, ey = np.float32(solids[n, 3]), np.float32(solids[n, 4])
        ez = np.float32(solids[n, 5])
        u0, u1 = windows[n, 0], windows[n, 1]
        cx, cy, cz = columns[0, u0:u1], columns[1, u0:u1], columns[2, u0:u1]
        for v in range(windows[n, 2], windows[n, 3]):
            bx, by, bz = rows[v, 0], rows[v, 1], rows[v, 2]
            row = nearness[v, u0:u1]
            for u in range(row.size):
                x, y, z = cx[u] + bx, cy[u] + by, cz[u] + bz
                x0, x1 = _slab(ox, cos * x + sin * y, ex)
                y0, y1 = _slab(oy, cos * y - sin * x, ey)
                z0, z1 = _slab(oz, z, ez)
                enter, leave = max(x0, y0, z0), min(x1, y1, z1)
                hit = (enter > np.float32(NEAR)) & (enter < leave)
                near = np.float32(1) / enter
                row[u] = near if hit & (near > row[u]) else row[u]


@njit(cache=True, nogil=True, error_model="numpy")
def sense(nearness, focal_baseline, sigma, dropout, near, far, seed, frame, out):
    """What a stereo pair makes of nearness (h, w) 1/m: `out` (h, w) uint16 mm, 0 for no return.

    Disparity is focal_baseline * nearness (px). Seen from the right-hand imager, what lies to the
    left of a nearer thing is hidden: holes. Some pixels at such edges fly between the two sides.
    The error is half each pixel's own, half shared by blocks of 4x4, as matching windows
    overlap; then disparity is quantised to 1/32 px.
    """
    height, width = nearness.shape
    scale, share = np.float32(focal_baseline), np.float32(np.sqrt(0.5) * sigma)
    low, high = np.float32(near), np.float32(far)
    faintest = scale / high - np.float32(5 * sigma + 1 / 32)  # no error makes more of less
    dropped = np.uint32(min(max(dropout, 0.0), 1.0) * 2**24)
    flies = np.uint32(FLYING * 2**16)
    disparity = np.empty(width + 1, np.float32)
    place = np.empty(width, np.float32)  # column in the right image
    taken = np.empty(width, np.float32)  # the leftmost there of all pixels to the right
    shared = np.empty(width, np.float32)
    own, luck = np.empty(width, np.uint32), np.empty(width, np.uint32)
    block = -1
    for v in range(height):
        row, target = nearness[v], out[v]
        lit = np.int32(0)
        for u in range(width):
            disparity[u] = scale * row[u]
            place[u] = np.float32(np.int32(u)) - scale * row[u]
            lit |= np.int32(scale * row[u] > faintest)
        if lit == 0:
            target[:] = 0
            continue
        disparity[width] = disparity[width - 1]
        least = np.float32(np.inf)
        for u in range(width - 1, -1, -1):
            taken[u] = least
            least = min(least, place[u])
        if v // 4 != block:
            block = v // 4
            _fill(_key(seed, block, frame), 2, own)
            for u in range(width):
                shared[u] = share * _gauss(own[u])
        _fill(_key(v, frame, seed), 0, own)
        _fill(_key(v, seed, frame), 0, luck)
        for u in range(width):
            d, beside = disparity[u], disparity[u + 1]
            edge = abs(d - beside) > np.float32(1)
            flying = edge & ((luck[u] & np.uint32(0xFFFF)) < flies)
            hidden = place[u] >= taken[u]
            between = np.float32(np.int32(luck[u] >> np.uint32(16))) * np.float32(2**-16)
            d += (beside - d) * between if flying else _NOTHING
            seen = (d > 0) & (flying | ~hidden) & ((luck[u] >> np.uint32(8)) >= dropped)
            d += share * _gauss(own[u]) + shared[u]
            d = np.floor(d * _STEPS + _HALF) * _STEP
            z = min(scale / max(d, _NOTHING), _FARTHEST)
            seen &= (z >= low) & (z <= high)
            target[u] = np.uint16(np.int32(z * np.float32(1000) + _HALF)) if seen else np.uint16(0)
