"""Which way the rows run: the directions and bends in which tree positions fall into stripes.

For a direction θ and a bend κ each tree has a place along (u) and across (v) the rows. With the
bend taken out, w = v - κu²/2, rows are peaks in the histogram of w, and its spectrum has a line at
the row spacing. The strength of that line, |Σ exp(2πi f w)|² / n, is what is searched; chance
alone gives it 1 on average, with an exponential tail.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely

from orchard_cli.model.arrays import Array, Points

NARROWEST, WIDEST = 1.8, 16.0  # m between rows that are searched
_REACH = 60.0  # m round the middle: farther out, directions would have to be searched finer
_BIN = 0.25  # m
_ALIGNED = 3.0
"""Nats in favour of the sides of the block: rows are planted along them more often than not."""
_KEPT = 8  # guesses


@dataclass(frozen=True, slots=True)
class Guess:
    """A way in which rows might run."""

    direction: float  # rad, of the rows, from +x towards +y, in [0, π)
    bend: float  # 1/m, of the rows at the middle; positive to the left
    spacing: float  # m, between rows
    strength: float  # nats


def guesses(points: Points, middle: Points, towards: float | None = None) -> list[Guess]:
    """The best ways, strongest first, well apart from each other. `points` (n, 2), m.

    `towards` limits them to directions within 10° of it, rad.
    """
    near = np.hypot(*(points - middle).T)
    patch = points[np.argsort(near)[: max(int((near <= _REACH).sum()), min(len(points), 40))]]
    patch = patch - middle
    extent = 2 * float(np.hypot(*patch.T).max())
    step = max(1.0 / max(extent, 10.0), 0.004)
    directions = np.arange(0.0, math.pi, step)
    if towards is not None:
        off = np.abs((directions - towards + math.pi / 2) % math.pi - math.pi / 2)
        directions = directions[off <= math.radians(10.0)]
    sides = _side_directions(patch)
    bends = _bends(extent)
    found = []
    for direction in directions:
        strength, bend, spacing = _best(patch, float(direction), bends)
        off = np.abs((direction - sides + math.pi / 2) % math.pi - math.pi / 2).min()
        strength += _ALIGNED * math.exp(-0.5 * (off / math.radians(2.0)) ** 2)
        found.append(Guess(float(direction), bend, spacing, strength))
    return _well_apart(found)


def _bends(extent: float) -> Array:
    """Curvatures to try, 1/m: bows of up to a tenth of the patch, a metre or so apart."""
    bows = np.arange(0.0, 0.1 * extent + 1e-9, 1.0)
    return 8.0 * np.concatenate([-bows[:0:-1], bows]) / extent**2


def _best(patch: Points, direction: float, bends: Array) -> tuple[float, float, float]:
    """Strength, bend and spacing of the strongest line for one direction."""
    c, s = math.cos(direction), math.sin(direction)
    u, v = patch @ np.array([c, s]), patch @ np.array([-s, c])
    w = v - bends[:, None] * u**2 / 2
    w -= w.min()
    size = 1 << max(8, math.ceil(math.log2(float(w.max()) / _BIN + 2)) + 1)
    cells = (w / _BIN).astype(np.int64) + size * np.arange(len(bends))[:, None]
    counts = np.bincount(cells.ravel(), minlength=size * len(bends)).reshape(len(bends), size)
    power = np.abs(np.fft.rfft(counts, axis=1)) ** 2 / len(patch)
    spacings = size * _BIN / np.maximum(np.arange(power.shape[1]), 1e-9)
    extent = float(np.ptp(v))
    allowed = (spacings >= NARROWEST) & (spacings <= min(WIDEST, max(extent, 2 * NARROWEST)))
    power[:, ~allowed] = 0.0
    bowed = 0.5 * np.log1p(np.abs(bends) * 100.0)  # straight is likelier
    at, f = np.unravel_index(int((power - bowed[:, None]).argmax()), power.shape)
    return float(power[at, f] - bowed[at]), float(bends[at]), float(spacings[f])


def _side_directions(patch: Points) -> Array:
    """(2,) rad: the sides of the smallest rectangle round the trees."""
    hull = shapely.MultiPoint(patch).minimum_rotated_rectangle
    corners = shapely.get_coordinates(hull)
    a, b = corners[:2] if len(corners) > 1 else np.array([[0.0, 0.0], [1.0, 0.0]])
    along = math.atan2(b[1] - a[1], b[0] - a[0]) % math.pi
    return np.array([along, (along + math.pi / 2) % math.pi])


def _well_apart(found: list[Guess]) -> list[Guess]:
    """The strongest, at least 4° from one another."""
    kept: list[Guess] = []
    for guess in sorted(found, key=lambda g: -g.strength):
        apart = (
            abs((guess.direction - k.direction + math.pi / 2) % math.pi - math.pi / 2) for k in kept
        )
        if all(a > math.radians(4.0) for a in apart):
            kept.append(guess)
        if len(kept) == _KEPT:
            break
    return kept
