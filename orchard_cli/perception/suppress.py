"""One box for each thing: non-maximum suppression."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.arrays import Array


def suppress(
    boxes: Array, scores: Array, classes: NDArray[np.int64], overlap: float
) -> NDArray[np.int64]:
    """Indices of the boxes that stay, best first: none overlaps a better one of its class by more
    than `overlap` (intersection over union). `boxes` (n, 4) are left, top, right, bottom.
    """
    order = np.argsort(-scores, kind="stable")
    kept: list[int] = []
    while len(order):
        best = int(order[0])
        kept.append(best)
        rest = order[1:]
        same = classes[rest] == classes[best]
        order = rest[~(same & (shared(boxes[best], boxes[rest]) > overlap))]
    return np.array(kept, dtype=np.int64)


def shared(box: Array, boxes: Array) -> Array:
    """Intersection over union of one box (4,) with each of (n, 4): (n,)."""
    low, high = np.maximum(box[:2], boxes[:, :2]), np.minimum(box[2:], boxes[:, 2:])
    both = np.prod(np.maximum(high - low, 0.0), axis=1)
    areas = np.prod(np.maximum(boxes[:, 2:] - boxes[:, :2], 0.0), axis=1)
    own = float(np.prod(np.maximum(box[2:] - box[:2], 0.0)))
    union: Array = np.maximum(areas + own - both, 1e-12)
    return np.asarray(both / union)
