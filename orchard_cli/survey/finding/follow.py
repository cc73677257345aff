"""Following curved rows: the common bend of all rows, from the phase of their stripes.

In a window of places along the rows the stripes' phase tells by how much the rows have moved
across; windows are taken outwards from the middle, each predicted by those before it, so that the
phase never jumps by a row.
"""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Array

from .search import Guess

_FEWEST = 12  # trees in a window


def common_curve(u: Array, v: Array, guess: Guess) -> Array:
    """(n,) m: how far the rows have moved across at each tree, from places along and across."""
    start = guess.bend * u**2 / 2
    window = max(12.0, 4.0 * guess.spacing)
    if np.ptp(u) < 2 * window:
        return start
    centres = np.arange(u.min() + window / 2, u.max(), window / 2)
    middle = int(np.abs(centres).argmin())
    moved = np.full(len(centres), math.nan)
    w = v - start
    moved[middle], reference = 0.0, _phase(u, w, centres[middle], window, guess.spacing)
    for order in (range(middle + 1, len(centres)), range(middle - 1, -1, -1)):
        behind = [0.0]
        for k in order:
            ahead = behind[-1] + (0.5 * (behind[-1] - behind[-2]) if len(behind) > 1 else 0.0)
            phase = _phase(u, w - ahead, centres[k], window, guess.spacing)
            turn = 0.0 if phase is None or reference is None else _wrapped(phase - reference)
            behind.append(ahead + 0.7 * turn * guess.spacing / (2 * math.pi))
            moved[k] = behind[-1]
    curve: Array = start + np.interp(u, centres, moved)
    return curve


def _phase(u: Array, w: Array, centre: float, window: float, spacing: float) -> float | None:
    """Phase of the stripes in a window, rad; None where too few trees tell."""
    inside = np.abs(u - centre) < window / 2
    if inside.sum() < _FEWEST:
        return None
    total = np.exp(2j * math.pi / spacing * w[inside]).sum()
    strength = abs(total) ** 2 / inside.sum()
    return float(np.angle(total)) if strength > 4.0 else None


def _wrapped(angle: float) -> float:
    return (angle + math.pi) % (2 * math.pi) - math.pi
