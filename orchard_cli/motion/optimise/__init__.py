"""The two optimisations of a span of control points (Liu 2024, §4.3 and §4.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.mapping import DistanceField
from orchard_cli.model.arrays import Array, Points
from orchard_cli.motion.checks import frame_of

from . import _kernels


@dataclass(frozen=True, slots=True)
class Weights:
    """Of the cost's terms; the paper names them and gives no values."""

    smooth: float = 1.0  # λ_1s, λ_2s: eq. 16
    jerk: float = 0.5  # even spacing in time; not in the paper, which leaves the spacing open
    guide: float = 0.0  # λ_1d: eq. 17
    collision: float = 0.0  # λ_2c: eqs. 19-20
    feasible: float = 0.0  # λ_2d: eqs. 22-25


WARM_UP = Weights(guide=0.02)
REFINE = Weights(collision=0.5, feasible=0.5)
HUG = Weights(guide=1.0)  # where there is little room beside the guide path
HUGGED = Weights(guide=0.2, collision=0.5, feasible=0.5)


@dataclass(frozen=True, slots=True)
class Targets:
    """What the second optimisation aims at; the check afterwards asks for a little less."""

    interval: float  # s between knots
    speed: float  # m/s
    acceleration: float  # m/s²
    distance: float  # m, d_thr of eq. 20
    softness: float = 0.1  # m over which eq. 20 is rounded off


def span_cost(
    span: Points, guide: Points, field: DistanceField, weights: Weights, targets: Targets
) -> tuple[float, Points]:
    """Cost of a span (n, 2) and its gradient (n, 2), 0 at the first and last three points."""
    grad = np.empty_like(span)
    cost = _kernels.span_cost(
        span, guide, _weights(weights), _limits(targets), field.values, frame_of(field), grad
    )
    return float(cost), grad


def optimise(
    span: Points,
    guide: Points,
    field: DistanceField,
    weights: Weights,
    targets: Targets,
    iterations: int = 60,
    tolerance: float = 1e-3,
) -> Points:
    """The span (n, 2) with its free points moved to where the cost is least (L-BFGS).

    `guide` (n, 2): the point of the guide path that belongs to each control point. The first and
    last three points stay. Raises ValueError when the shapes differ or nothing is free.
    """
    if span.shape != guide.shape or span.ndim != 2 or span.shape[1] != 2:
        raise ValueError(f"span {span.shape} and guide {guide.shape}: expected two nx2")
    if len(span) <= 2 * _kernels.FIXED:
        raise ValueError("a span needs a free point between its fixed three at each end")
    better = np.array(span, dtype=np.float64, order="C")
    _kernels.minimise(
        better, np.ascontiguousarray(guide), _weights(weights), _limits(targets),
        field.values, frame_of(field), iterations, tolerance,
    )  # fmt: skip
    return better


def _weights(w: Weights) -> Array:
    return np.array([w.smooth, w.jerk, w.guide, w.collision, w.feasible])


def _limits(t: Targets) -> Array:
    return np.array([t.interval, t.speed, t.acceleration, t.distance, t.softness])
