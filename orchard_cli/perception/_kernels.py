"""Depth images cut into surfaces that hang together, and the moments of each."""

from __future__ import annotations

import numpy as np
from numba import njit

COUNT, LEFT, RIGHT, TOP, BOTTOM = 0, 1, 2, 3, 4
HIDDEN_LEFT, HIDDEN_RIGHT, HIDDEN_TOP, HIDDEN_BOTTOM = 5, 6, 7, 8
SUMS = 9  # x, y, z, xx, xy, xz, yy, yz, zz
LOWEST, HIGHEST, NEAREST, FARTHEST = 18, 19, 20, 21
FEATURES = 22
BESIDE = 3  # px within which a neighbour is looked for


@njit(cache=True, nogil=True)
def _gap(z, base, growth):
    """m between two pixels of one surface, at most: leaves, and noise that grows with z²."""
    return base + growth * z * z


@njit(cache=True, nogil=True)
def shrink(depth_mm, block, near, far, base, growth, out):
    """Depth (h, w) mm -> out (h // block, w // block) m: the nearest surface of each block.

    0 is no return, or one outside near to far. Pixels of the block's nearest surface are averaged.
    """
    for v in range(out.shape[0]):
        for u in range(out.shape[1]):
            least = np.inf
            for j in range(block):
                for i in range(block):
                    z = 0.001 * depth_mm[v * block + j, u * block + i]
                    if near <= z <= far:
                        least = min(least, z)
            total, n = 0.0, 0
            if least < np.inf:
                reach = least + _gap(least, base, growth)
                for j in range(block):
                    for i in range(block):
                        z = 0.001 * depth_mm[v * block + j, u * block + i]
                        if least <= z <= reach:
                            total += z
                            n += 1
            out[v, u] = total / n if n else 0.0


@njit(cache=True, nogil=True)
def drop_ground(depth, columns, rows, position, plane, height, slack):
    """Set to 0 what lies less than height + slack * depth above the plane z = a x + b y + c."""
    px, py, pz = position
    for v in range(depth.shape[0]):
        bx, by, bz = rows[v]
        for u in range(depth.shape[1]):
            z = depth[v, u]
            if z > 0.0:
                x = px + z * (columns[0, u] + bx)
                y = py + z * (columns[1, u] + by)
                over = pz + z * (columns[2, u] + bz) - plane[0] * x - plane[1] * y - plane[2]
                if over < height + slack * z:
                    depth[v, u] = 0.0


@njit(cache=True, nogil=True)
def drop_lonely(depth, base, growth, least, out):
    """Copy the pixels with `least` of their eight neighbours on their own surface: flying pixels
    between a near edge and what is behind it have fewer."""
    height, width = depth.shape
    for v in range(height):
        for u in range(width):
            z = depth[v, u]
            out[v, u] = 0.0
            if z == 0.0:
                continue
            reach, n = _gap(z, base, growth), 0
            for j in range(max(v - 1, 0), min(v + 2, height)):
                for i in range(max(u - 1, 0), min(u + 2, width)):
                    other = depth[j, i]
                    if (i != u or j != v) and other > 0.0 and abs(other - z) <= reach:
                        n += 1
            if n >= least:
                out[v, u] = z


@njit(cache=True, nogil=True)
def _root(parent, i):
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@njit(cache=True, nogil=True)
def label(depth, base, growth, parent, labels):
    """Number (h, w) pixels by surface, from 1; 0 where there is none. Returns how many surfaces.

    Neighbours, and pixels one hole apart, are of one surface when their depths are near.
    """
    height, width = depth.shape
    for v in range(height):
        for u in range(width):
            k, z = v * width + u, depth[v, u]
            parent[k] = k
            if z == 0.0:
                continue
            reach = _gap(z, base, growth)
            for j, i in ((0, -1), (-1, -1), (-1, 0), (-1, 1), (0, -2), (-2, 0)):
                a, b = v + j, u + i
                if a < 0 or b < 0 or b >= width:
                    continue
                if depth[a, b] > 0.0 and abs(depth[a, b] - z) <= reach:
                    one, two = _root(parent, k), _root(parent, a * width + b)
                    parent[max(one, two)] = min(one, two)
    count = 0
    for v in range(height):
        for u in range(width):
            k = v * width + u
            if depth[v, u] == 0.0:
                labels[v, u] = 0
                continue
            root = _root(parent, k)
            if root == k:
                count += 1
                labels[v, u] = count
            else:
                labels[v, u] = labels[root // width, root % width]
    return count


@njit(cache=True, nogil=True)
def measure(depth, labels, columns, rows, base, growth, out):
    """Features (n, FEATURES) of each surface; points are from the lens, site axes.

    HIDDEN_*: pixels on that side whose neighbour is nearer: something stands before the surface.
    """
    height, width = depth.shape
    out[:] = 0.0
    out[:, LEFT], out[:, TOP] = width, height
    out[:, RIGHT], out[:, BOTTOM] = -1, -1
    out[:, LOWEST], out[:, HIGHEST], out[:, NEAREST] = np.inf, -np.inf, np.inf
    for v in range(height):
        for u in range(width):
            n = labels[v, u] - 1
            if n < 0:
                continue
            z, f = depth[v, u], out[n]
            x = z * (columns[0, u] + rows[v, 0])
            y = z * (columns[1, u] + rows[v, 1])
            h = z * (columns[2, u] + rows[v, 2])
            f[COUNT] += 1
            f[LEFT], f[RIGHT] = min(f[LEFT], u), max(f[RIGHT], u)
            f[TOP], f[BOTTOM] = min(f[TOP], v), max(f[BOTTOM], v)
            for k, value in enumerate((x, y, h, x * x, x * y, x * h, y * y, y * h, h * h)):
                f[SUMS + k] += value
            f[LOWEST], f[HIGHEST] = min(f[LOWEST], h), max(f[HIGHEST], h)
            f[NEAREST], f[FARTHEST] = min(f[NEAREST], z), max(f[FARTHEST], z)
            reach = _gap(z, base, growth)
            for side, (j, i) in enumerate(((0, -1), (0, 1), (-1, 0), (1, 0))):
                for step in range(1, BESIDE + 1):
                    a, b = v + j * step, u + i * step
                    if not (0 <= a < height and 0 <= b < width):
                        break
                    other = depth[a, b]
                    if other > 0.0:
                        f[HIDDEN_LEFT + side] += other < z - 2.0 * reach
                        break
