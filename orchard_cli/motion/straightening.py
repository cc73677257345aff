"""Fewer points for a path."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Points


def straightened(path: Points, tolerance: float) -> Points:
    """The fewest of the points (n, 3) from which none is farther than `tolerance` m in space.

    Ramer-Douglas-Peucker; the first and the last point stay.
    """
    keep = np.zeros(len(path), dtype=bool)
    keep[[0, -1]] = True
    spans = [(0, len(path) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        inner, chord = path[first + 1 : last] - path[first], path[last] - path[first]
        length = float(chord @ chord)
        share = np.clip(inner @ chord / length, 0.0, 1.0) if length > 0 else np.zeros(len(inner))
        off = np.linalg.norm(inner - share[:, None] * chord, axis=1)
        worst = int(np.argmax(off))
        if off[worst] > tolerance:
            middle = first + 1 + worst
            keep[middle] = True
            spans += [(first, middle), (middle, last)]
    kept: Points = path[keep]
    return kept
