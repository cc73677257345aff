"""Loops over the pixels of a depth image."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def texture(depth_mm, every, leap):
    """Of every so many-th row of an image (height, width), mm, 0: no return. Counts

    pairs of neighbours with returns; those of them that differ by more than `leap` of the nearer
    one; and pixels of the same depth as the first return.
    """
    first = np.int32(0)
    pairs, leaps, alike = 0, 0, 0
    for v in range(0, depth_mm.shape[0], every):
        row = depth_mm[v]
        both, far, same = np.int32(0), np.int32(0), np.int32(0)
        for u in range(row.size - 1):
            left, right = np.int32(row[u]), np.int32(row[u + 1])
            two = np.int32(left > 0) & np.int32(right > 0)
            wide = np.float32(abs(left - right)) > leap * np.float32(min(left, right))
            both += two
            far += two & np.int32(wide)
        if first == 0:
            for u in range(row.size):
                if row[u] > 0:
                    first = np.int32(row[u])
                    break
        for u in range(row.size):
            same += np.int32(np.int32(row[u]) == first)
        pairs += int(both)
        leaps += int(far)
        alike += int(same) if first > 0 else 0
    return pairs, leaps, alike
