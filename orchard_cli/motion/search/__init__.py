"""A* in the local map, the geometric guide path of Liu 2024, §4.2."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.mapping import DistanceField
from orchard_cli.model.arrays import Points, Vector

from . import _kernels

_STRIDE = 2  # the search takes every second cell: inflated obstacles have no finer shape


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """A way found: straight legs between points, free of obstacles by the limit asked for."""

    points_site: Points  # (n, 2) m, from start to goal
    cost: int  # cells expanded


@dataclass(frozen=True, slots=True)
class NoRoute:
    """There is no way, and why."""

    why: str
    cost: int = 0  # cells expanded


def find_route(
    field: DistanceField,
    start_site: Vector,
    goal_site: Vector,
    clearance: float,
    near_site: Points | None = None,
    stray: float = 0.0,
) -> Route | NoRoute:
    """Shortest 8-connected way between two points (2,), straightened by line of sight.

    `clearance`: least distance to obstacles, m; where start or goal lie nearer, so may the way,
    but no nearer than they. `near_site` (n, 2): a way that strays from these points costs
    `stray` per metre more: it ties the side that is taken to the path that was being flown.
    """
    origin, values = field.origin_site, field.values
    coarse = np.ascontiguousarray(values[::_STRIDE, ::_STRIDE])
    step = field.cell * _STRIDE
    corner = origin + (field.cell - step) / 2  # of coarse cell [0, 0], about its fine one's centre
    ends = np.floor((np.stack([start_site[:2], goal_site[:2]]) - corner) / step).astype(np.int64)
    if (ends < 0).any() or (ends >= coarse.shape).any():
        return NoRoute("start or goal lies outside the local map")
    limit = min(clearance, float(coarse[tuple(ends[0])]), float(coarse[tuple(ends[1])]))
    if limit <= 0:
        return NoRoute("start or goal lies in an obstacle")
    near = np.empty((0, 2)) if near_site is None else (near_site[:, :2] - corner) / step - 0.5
    path = np.empty((coarse.size, 2), dtype=np.int32)
    length, expanded = _kernels.find_path(
        coarse, limit, ends[0], ends[1], near, stray * step if len(near) else 0.0, path
    )
    if length == 0:
        return NoRoute("no way round within the local map", expanded)
    legs = np.empty((length, 2), dtype=np.int32)
    kept = _kernels.straighten(coarse, limit, path, length, legs)
    points = corner + (legs[:kept] + 0.5) * step
    points[0], points[-1] = start_site[:2], goal_site[:2]
    return Route(points, expanded)
