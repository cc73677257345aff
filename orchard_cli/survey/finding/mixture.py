"""Trees to rows: a mixture of gently bent lines with a common scatter, fitted by expectation
maximisation, and how short a description of the trees it is.

Each row is a parabola over the places along it, held near the common curve by a prior. The score
is the log likelihood of the positions (a row is picked, then a place along it, then a scatter
across it) less what the rows' numbers cost (BIC), and more for rows that lie evenly. Rows beat
columns and diagonals of the same grid by it, as they need the fewest metres of line.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array, Indices

_BANDWIDTHS = (0.35, 0.7, 1.1, 1.6)  # m
_ROUNDS = 30
_SCATTER_LEAST = 0.1  # m: nobody plants straighter
_OUTLYING = 3.5  # scatters
_OUTLYING_LEAST = 0.8  # m
_EVEN, _UNEVEN = 0.1, 3.0  # of the median distance between rows
_BOW, _SLANT, _LEVEL = 0.4, 0.8, 50.0  # m at a row's end, prior standard deviations


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """Rows as fitted, in the order in which they lie across."""

    member: Indices  # (n,) index of the tree's row, -1: in none
    across: Array  # (n,) m, of the tree's row where the tree stands
    levels: Array  # (k,) m across, increasing
    scatter: float  # m, standard deviation of trees about their rows
    doubt: float  # share of trees expected in a wrong row
    score: float  # nats


def fits(u: Array, w: Array, spacing: float) -> list[Rows]:
    """Rows for places along (u) and, straightened, across (w), both (n,) m, in several ways.

    They begin as the peaks of the density across, and as a comb of this spacing: where scatter
    blurs the peaks the comb finds rows as good as evenly spaced ones are.
    """
    found: list[Rows] = []
    tried: set[tuple[int, ...]] = set()
    starts = [(bandwidth, _peaks(w, bandwidth)) for bandwidth in _BANDWIDTHS]
    starts.append((0.2 * spacing, _comb(w, spacing)))
    for bandwidth, levels in starts:
        key = tuple(np.round(levels).astype(int))
        if not 0 < len(levels) <= max(1, len(u) // 2) or key in tried:
            continue
        tried.add(key)
        rows = _refined(u, w, levels, bandwidth)
        if rows is not None:
            found.append(rows)
    return found


def _comb(w: Array, spacing: float) -> Array:
    """Evenly spaced levels in phase with the trees; at the edges only where trees stand."""
    spacings = spacing * np.linspace(0.96, 1.04, 33)
    sums = np.exp(2j * math.pi * w[:, None] / spacings).sum(axis=0)
    best = int(np.abs(sums).argmax())
    spacing = float(spacings[best])
    tooth = np.round(w / spacing - np.angle(sums[best]) / (2 * math.pi)).astype(int)
    teeth, trees = np.unique(tooth, return_counts=True)
    teeth = teeth[trees > 0.3 * np.median(trees)]
    every = np.arange(teeth.min(), teeth.max() + 1)
    levels = (every + np.angle(sums[best]) / (2 * math.pi)) * spacing
    return np.asarray(levels, dtype=np.float64)


def _peaks(w: Array, bandwidth: float) -> Array:
    """Levels of the peaks of the density across, smoothed by a Gaussian of this bandwidth."""
    step = bandwidth / 4
    low = float(w.min()) - 4 * bandwidth
    cells = ((w - low) / step).astype(int)
    counts = np.bincount(cells, minlength=int(cells.max()) + 17).astype(float)
    kernel = np.exp(-0.5 * (np.arange(-16, 17) / 4.0) ** 2)
    density = np.convolve(counts, kernel, mode="same")
    inner = density[1:-1]
    top = (inner > density[:-2]) & (inner >= density[2:])
    at = np.flatnonzero(top) + 1
    at = at[density[at] > 0.12 * np.quantile(density[at], 0.8)] if len(at) else at
    return np.asarray(low + (at + 0.5) * step, dtype=np.float64)


def _refined(u: Array, w: Array, levels: Array, scatter: float) -> Rows | None:
    """Expectation maximisation from rows at these levels; rows that lose their trees go."""
    half = max(float(np.ptp(u)) / 2, 1.0)
    t = (u - (u.min() + u.max()) / 2) / half  # -1..1
    basis = np.column_stack([np.ones_like(t), t, t * t - 1 / 3])
    prior = np.array([1 / _LEVEL**2, 1 / _SLANT**2, 1 / _BOW**2])
    curves = np.column_stack([levels, np.zeros((len(levels), 2))])
    scatter = max(scatter, _SCATTER_LEAST)
    for _ in range(_ROUNDS):
        share, off = _shares(w, basis, curves, scatter)
        weight = share.sum(axis=0)
        keep = weight > 1.5
        if not keep.any():
            return None
        if not keep.all():
            curves = curves[keep]
            continue
        before = curves
        curves = _curves(w, basis, share, prior / scatter**-2)
        off = w[:, None] - basis @ curves.T
        scatter = _scatter(share, off)
        if before.shape == curves.shape and np.abs(before - curves).max() < 1e-3:
            break
    return _judged(u, w, basis, curves, scatter)


def _shares(w: Array, basis: Array, curves: Array, scatter: float) -> tuple[Array, Array]:
    """(n, k) share of each row in each tree, and how far off (n, k) m; far-off trees count less."""
    off = w[:, None] - basis @ curves.T
    z = -0.5 * (off / scatter) ** 2
    top = z.max(axis=1, keepdims=True)
    share: Array = np.exp(z - top)
    stray = math.exp(-0.5 * _OUTLYING**2)
    share *= (1.0 / (share.sum(axis=1) + stray * np.exp(-np.maximum(top[:, 0], -600.0))))[:, None]
    return share, off


def _curves(w: Array, basis: Array, share: Array, ridge: Array) -> Array:
    """(k, 3) weighted least squares, a row each, with the prior as a ridge."""
    squares = (basis[:, :, None] * basis[:, None, :]).reshape(-1, 9)
    normal = (share.T @ squares).reshape(-1, 3, 3) + np.diag(ridge)
    right = share.T @ (basis * w[:, None])
    return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0], dtype=np.float64)


def _scatter(share: Array, off: Array) -> float:
    squares = float((share * off**2).sum()) / max(float(share.sum()), 1e-9)
    return max(math.sqrt(squares), _SCATTER_LEAST)


def _judged(u: Array, w: Array, basis: Array, curves: Array, scatter: float) -> Rows | None:
    """Members, doubt and score of fitted rows; a row of one tree is none."""
    while True:
        curves = curves[np.argsort(curves[:, 0])]
        share, off = _shares(w, basis, curves, scatter)
        member = np.abs(off).argmin(axis=1)
        distance = np.abs(off)[np.arange(len(w)), member]
        member[distance > max(_OUTLYING * scatter, _OUTLYING_LEAST)] = -1
        trees = np.bincount(member[member >= 0], minlength=len(curves))
        if (trees > 1).all():
            break
        curves = curves[trees > 1]
        if not len(curves):
            return None
    inside = member >= 0
    total = share.sum(axis=1)
    doubt = float(np.mean(1 - (share.max(axis=1) / np.maximum(total, 1e-9))[inside]))
    across = (basis * curves[np.maximum(member, 0)]).sum(axis=1)
    score = _score(u, off, member, trees, scatter, len(curves)) + _evenness(curves[:, 0])
    return Rows(member, across, curves[:, 0], scatter, doubt, score)


def _score(
    u: Array, off: Array, member: Indices, trees: Indices, scatter: float, rows: int
) -> float:
    n = len(u)
    density = np.full(n, 0.0)
    for k in range(rows):
        along = u[member == k]
        length = float(np.ptp(along)) * (trees[k] + 1) / max(trees[k] - 1, 1) + 1e-3
        low = (float(along.min()) + float(along.max()) - length) / 2
        inside = (u >= low) & (u <= low + length)
        normal = np.exp(-0.5 * (off[:, k] / scatter) ** 2) / (scatter * math.sqrt(2 * math.pi))
        density += inside * normal * trees[k] / n / length
    area = max(float(np.ptp(u)), 1.0) * max(float(np.ptp(off[:, 0])), 1.0)
    log_likelihood = float(np.log(0.98 * density + 0.02 / area).sum())
    return log_likelihood - 0.5 * math.log(n) * (3 * rows + 1)


def _evenness(levels: Array) -> float:
    """Nats for rows that lie evenly, as orchards are planted, but for a road or a lane.

    Each distance, over their median, is normal about 1 for nine of ten, and anything up to _UNEVEN
    for the tenth.
    """
    if len(levels) < 3:
        return 0.0
    apart = np.diff(levels)
    off = (apart / np.median(apart) - 1) / _EVEN
    normal = np.exp(-0.5 * off**2) / (_EVEN * math.sqrt(2 * math.pi))
    return float(np.log(0.9 * normal + 0.1 / _UNEVEN).sum())
