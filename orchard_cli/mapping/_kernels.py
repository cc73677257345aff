"""Loops over pixels and cells of the occupancy grid.

A cell's place in the arrays is its integer site index modulo the power-of-two size, so the grid
rolls with the vehicle without moving memory: `log_odds[i & mask_x, j & mask_y, k & mask_z]`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

STRETCH = 64  # px of a row that are looked at together: most hold no return within range
BLOCK = 4  # px: carving looks at the nearest return of each 4x4 block


@njit(cache=True, nogil=True)
def nearest_blocks(depth_mm, near_mm, out):
    """Nearest return of each 4x4 block, mm; 0 where fewer than half of its pixels returned.

    `out`: (height // 4, width // 4) float32. Taking the nearest keeps a wire that covers one of
    four rows; asking for half keeps a hole from carving.
    """
    for row in range(out.shape[0]):
        for column in range(out.shape[1]):
            nearest = np.int32(65536)
            returns = 0
            for v in range(BLOCK * row, BLOCK * row + BLOCK):
                for u in range(BLOCK * column, BLOCK * column + BLOCK):
                    d = np.int32(depth_mm[v, u])
                    good = d >= near_mm
                    returns += good
                    nearest = min(nearest, d if good else np.int32(65536))
            out[row, column] = nearest if returns >= BLOCK * BLOCK // 2 else 0


@njit(cache=True, nogil=True)
def count_hits(
    depth_mm,
    near_mm,
    far_mm,
    column_rays,
    row_rays,
    camera_cells,
    lower,
    size,
    counts,
    touched,
    row,
):
    """Count the returns in every cell. Returns (cells touched, returns within range).

    A return lies at `camera + depth * (column_ray + row_ray)` in cells (Liu 2024, eqs. 4-8, with
    the rotation folded into the rays). `touched` receives the flat place of each cell on its
    first return; `row` is scratch, STRETCH int32.
    """
    x0 = np.float32(camera_cells[0] - lower[0])
    y0 = np.float32(camera_cells[1] - lower[1])
    z0 = np.float32(camera_cells[2] - lower[2])
    nx, ny, nz = np.int32(size[0]), np.int32(size[1]), np.int32(size[2])
    lx, ly, lz = np.int32(lower[0]), np.int32(lower[1]), np.int32(lower[2])
    near, far = np.int32(near_mm), np.int32(far_mm)
    flat = counts.ravel()
    cells = 0
    returns = 0
    for v in range(depth_mm.shape[0]):
        bx, by, bz = row_rays[v, 0], row_rays[v, 1], row_rays[v, 2]
        for first in range(0, depth_mm.shape[1], STRETCH):
            part = depth_mm[v, first : first + STRETCH]
            some = np.int32(0)
            for u in range(part.size):
                d = np.int32(part[u])
                some |= np.int32(d >= near) & np.int32(d <= far)
            if some == 0:
                continue
            rx, ry, rz = (
                column_rays[0, first : first + STRETCH],
                column_rays[1, first : first + STRETCH],
                column_rays[2, first : first + STRETCH],
            )
            for u in range(part.size):
                d = np.int32(part[u])
                r = np.float32(d)
                x = x0 + r * (rx[u] + bx)
                y = y0 + r * (ry[u] + by)
                z = z0 + r * (rz[u] + bz)
                i, j, k = np.int32(x), np.int32(y), np.int32(z)
                inside = (
                    (d >= near) & (d <= far)
                    & (x >= 0) & (y >= 0) & (z >= 0) & (i < nx) & (j < ny) & (k < nz)
                )  # fmt: skip
                i, j, k = (i + lx) & (nx - 1), (j + ly) & (ny - 1), (k + lz) & (nz - 1)
                row[u] = (i * ny + j) * nz + k if inside else -1
            for u in range(part.size):
                place = row[u]
                if place >= 0:
                    returns += 1
                    seen = flat[place]
                    if seen == 0:
                        touched[cells] = place
                        cells += 1
                    if seen < 255:
                        flat[place] = seen + 1
    return cells, returns


@njit(cache=True, nogil=True)
def _inside(planes, i, j, low, high):
    """The cells k of column (i, j) with `planes @ (i, j, k, 1) >= 0`: [start, stop)."""
    first, last = float(low), float(high - 1)
    for side in range(planes.shape[0]):
        base = planes[side, 0] * i + planes[side, 1] * j + planes[side, 3]
        slope = planes[side, 2]
        if slope > 1e-9:
            first = max(first, -base / slope)
        elif slope < -1e-9:
            last = min(last, -base / slope)
        elif base < 0:
            return low, low
    return int(np.ceil(first)), int(np.floor(last)) + 1


@njit(cache=True, nogil=True)
def _topmost(blocks, out):
    """The first row of each column of blocks with a return; as many as there are rows if none."""
    rows = blocks.shape[0]
    out[:] = rows
    for v in range(rows - 1, -1, -1):
        row = blocks[v]
        for u in range(row.size):
            out[u] = v if row[u] > 0 else out[u]


@njit(cache=True, nogil=True)
def _under_sky(tops, rows, au, av, az, su, sv, sz, count):
    """How many of `count` cells of a column may be seen in or under the topmost returns there.

    Cell n is seen in block ((au + su n), (av + sv n)) / (az + sz n); sky says nothing of a cell.
    """
    end = np.float32(count - 1)
    first = min(max(np.int32(au / az), 0), tops.size - 1)
    last = min(max(np.int32((au + su * end) / (az + sz * end)), 0), tops.size - 1)
    top = np.int32(rows)
    for u in range(min(first, last), max(first, last) + 1):
        top = min(top, tops[u])
    over, climb = av - top * az, sv - top * sz  # in rows, times z, and its change from cell to cell
    return min(count, max(int(over / -climb) + 2, 0)) if climb < 0 else count


@njit(cache=True, nogil=True)
def carve(blocks, block_from_cell, planes, margin, box, min_hits, miss, floor, counts, log_odds):
    """One miss for every cell whose centre is seen and lies nearer than the return behind it.

    Walks the cells of `box` (lower and upper site indices, within the grid) column by column,
    each inside the view `planes` (n, 4). `block_from_cell @ (i, j, k, 1)` is (column * z, row * z,
    z) of the block that sees the cell's centre, z its depth in metres. Cells that were hit in
    this frame are left alone, and those that are as free as they can be (most of them, in flight)
    are not looked at. Returns the number of cells carved.
    """
    rows, columns = blocks.shape
    mx, my, mz = log_odds.shape[0] - 1, log_odds.shape[1] - 1, log_odds.shape[2] - 1
    p = block_from_cell
    su, sv, sz = np.float32(p[0, 2]), np.float32(p[1, 2]), np.float32(p[2, 2])
    tops = np.empty(columns, dtype=np.int32)
    _topmost(blocks, tops)
    carved = 0
    for i in range(box[0], box[3]):
        for j in range(box[1], box[4]):
            start, stop = _inside(planes, i, j, box[2], box[5])
            if start >= stop:
                continue
            au = np.float32(p[0, 0] * i + p[0, 1] * j + p[0, 2] * start + p[0, 3])
            av = np.float32(p[1, 0] * i + p[1, 1] * j + p[1, 2] * start + p[1, 3])
            az = np.float32(p[2, 0] * i + p[2, 1] * j + p[2, 2] * start + p[2, 3])
            count = _under_sky(tops, rows, au, av, az, su, sv, sz, stop - start)
            column = log_odds[i & mx, j & my]
            hits = counts[i & mx, j & my]
            for n in range(count):
                k = (start + n) & mz
                if column[k] <= floor:
                    continue
                step = np.float32(n)
                z = az + sz * step
                scale = np.float32(1) / z
                u = min(max(np.int32((au + su * step) * scale), 0), columns - 1)
                v = min(max(np.int32((av + sv * step) * scale), 0), rows - 1)
                if blocks[v, u] > (z + margin) * np.float32(1000) and hits[k] < min_hits:
                    column[k] = max(column[k] + miss, floor)
                    carved += 1
    return carved


@njit(cache=True, nogil=True)
def vote_hits(touched, min_hits, hit, ceiling, counts, log_odds):
    """One hit for every touched cell with enough returns; sets the counts back to 0.

    Returns the number of cells hit.
    """
    flat_counts = counts.ravel()
    flat = log_odds.ravel()
    voted = 0
    for n in range(touched.size):
        place = touched[n]
        if flat_counts[place] >= min_hits:
            flat[place] = min(flat[place] + hit, ceiling)
            voted += 1
        flat_counts[place] = 0
    return voted


@njit(cache=True, nogil=True)
def fade(log_odds, keep):
    """Multiply by `keep` (0 to 1), rounding towards 0: evidence is forgotten, never turned."""
    flat = log_odds.ravel()
    for n in range(flat.size):
        flat[n] = np.int16(flat[n] * keep)


@njit(cache=True, nogil=True)
def look_down(log_odds, corner, box, threshold, occupied, observed):
    """Columns of a band whose cell [0, 0] is the site index `corner` (2,), as far as `box` goes.

    Occupied when any cell of the box's heights is, observed when any was ever seen.
    """
    mx, my, mz = log_odds.shape[0] - 1, log_odds.shape[1] - 1, log_odds.shape[2] - 1
    for i in range(box[0], box[3]):
        for j in range(box[1], box[4]):
            column = log_odds[i & mx, j & my]
            highest = np.int16(-32768)
            known = False
            for k in range(box[2], box[5]):
                value = column[k & mz]
                highest = max(highest, value)
                known |= value != 0
            occupied[i - corner[0], j - corner[1]] = highest >= threshold
            observed[i - corner[0], j - corner[1]] = known


@njit(cache=True, nogil=True)
def look_into(log_odds, corner, box, threshold, occupied):
    """Obstacle cells of a box; `occupied[0, 0, 0]` is the site index `corner` (3,).

    Each column is at most two runs of memory, which are compared in lanes.
    """
    mx, my, nz = log_odds.shape[0] - 1, log_odds.shape[1] - 1, log_odds.shape[2]
    lowest, count = box[2] & (nz - 1), box[5] - box[2]
    first = min(count, nz - lowest)
    base = box[2] - corner[2]
    for i in range(box[0], box[3]):
        for j in range(box[1], box[4]):
            column = log_odds[i & mx, j & my]
            out = occupied[i - corner[0], j - corner[1]]
            for k in range(first):
                out[base + k] = column[lowest + k] >= threshold
            for k in range(count - first):
                out[base + first + k] = column[k] >= threshold


@njit(cache=True, nogil=True)
def gather(log_odds, box, centre_cells, radius_cells, threshold, out):
    """Site indices of the occupied cells of `box` within a radius. Returns how many there are."""
    mx, my, mz = log_odds.shape[0] - 1, log_odds.shape[1] - 1, log_odds.shape[2] - 1
    found = 0
    reach = radius_cells * radius_cells
    for i in range(box[0], box[3]):
        for j in range(box[1], box[4]):
            flat = (i + 0.5 - centre_cells[0]) ** 2 + (j + 0.5 - centre_cells[1]) ** 2
            if flat > reach:
                continue
            column = log_odds[i & mx, j & my]
            for k in range(box[2], box[5]):
                if column[k & mz] >= threshold and flat + (k + 0.5 - centre_cells[2]) ** 2 <= reach:
                    if found < out.shape[0]:
                        out[found, 0], out[found, 1], out[found, 2] = i, j, k
                    found += 1
    return found


@njit(cache=True, nogil=True)
def empty_sphere(log_odds, box, centre_cells, radius_cells, value):
    """Set every cell of `box` whose centre lies within the radius to `value`."""
    mx, my, mz = log_odds.shape[0] - 1, log_odds.shape[1] - 1, log_odds.shape[2] - 1
    for i in range(box[0], box[3]):
        for j in range(box[1], box[4]):
            flat = (i + 0.5 - centre_cells[0]) ** 2 + (j + 0.5 - centre_cells[1]) ** 2
            for k in range(box[2], box[5]):
                if flat + (k + 0.5 - centre_cells[2]) ** 2 <= radius_cells * radius_cells:
                    log_odds[i & mx, j & my, k & mz] = value


@njit(cache=True, nogil=True)
def squared_distance(occupied, reach, out):
    """Squared distance in cells from each cell's centre to the nearest occupied one's, exact.

    Capped at reach² (reach in whole cells). Two passes: along y within each row of the array,
    then across rows; the second is a plain minimum over 2 * reach + 1 shifted rows, which for a
    short reach beats the lower envelope of parabolas (Felzenszwalb 2012) as it runs in lanes.
    """
    nx, ny = occupied.shape
    cap = np.float32(reach * reach)
    along = np.empty((nx, ny), dtype=np.float32)
    empty = np.ones(nx, dtype=np.bool_)
    for i in range(nx):
        since = reach
        for j in range(ny):
            since = 0 if occupied[i, j] else min(since + 1, reach)
            along[i, j] = since
            if since == 0:
                empty[i] = False
        since = reach
        for j in range(ny - 1, -1, -1):
            since = 0 if occupied[i, j] else min(since + 1, reach)
            nearest = min(along[i, j], np.float32(since))
            along[i, j] = nearest * nearest
    out[:] = cap
    for i in range(nx):
        if empty[i]:
            continue
        for target in range(max(0, i - reach), min(nx, i + reach + 1)):
            step = np.float32((target - i) * (target - i))
            source, row = along[i], out[target]
            for j in range(ny):
                row[j] = min(row[j], source[j] + step)


@njit(cache=True, nogil=True)
def sample_field(values, origin, cell, outside, points, distances, gradients):
    """Bilinear value and its gradient at points (n, 2); cells beyond the field are `outside`."""
    nx, ny = values.shape
    for n in range(points.shape[0]):
        x = (points[n, 0] - origin[0]) / cell - 0.5
        y = (points[n, 1] - origin[1]) / cell - 0.5
        x = min(max(x, -2.0), nx + 1.0)
        y = min(max(y, -2.0), ny + 1.0)
        i, j = int(np.floor(x)), int(np.floor(y))
        fx, fy = x - i, y - j
        in_i, in_i1 = 0 <= i < nx, 0 <= i + 1 < nx
        in_j, in_j1 = 0 <= j < ny, 0 <= j + 1 < ny
        v00 = values[i, j] if in_i and in_j else outside
        v10 = values[i + 1, j] if in_i1 and in_j else outside
        v01 = values[i, j + 1] if in_i and in_j1 else outside
        v11 = values[i + 1, j + 1] if in_i1 and in_j1 else outside
        low = v00 + fx * (v10 - v00)
        high = v01 + fx * (v11 - v01)
        distances[n] = low + fy * (high - low)
        gradients[n, 0] = ((1 - fy) * (v10 - v00) + fy * (v11 - v01)) / cell
        gradients[n, 1] = (high - low) / cell
