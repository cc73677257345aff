"""Is a trajectory free in the map? In three dimensions, for it may leap."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from orchard_cli.mapping import OccupancyGrid
from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.mission import Limits
from orchard_cli.model.trajectory import Trajectory

STEP = 0.1  # s between samples
SLACK = 0.02  # m: how much nearer than it was a walk that begins too near may come
MARGIN = 0.6  # m looked at beyond the clearance


@dataclass(frozen=True, slots=True)
class Walk:
    """What a walk along a trajectory met."""

    blocked_at: float | None  # m of path to the first place that is too near; None: free
    clearance: float  # m, least distance to an obstacle, heights stretched; at most what is seen


def walk(
    grid: OccupancyGrid,
    trajectory: Trajectory,
    begin: float,
    end: float,
    limits: Limits,
    vertical: float,
    more: float = 0.0,
) -> Walk:
    """From time `begin` to `end`, keeping Limits.clearance, half a cell and `more` m to the sides,
    and `vertical` m above and below. A walk that begins too near may leave but not come nearer.
    """
    places = samples(trajectory, begin, end)
    if len(places) == 0:
        return Walk(None, math.inf)
    stretch = limits.clearance / vertical
    apart, cell = _distances(grid, places, limits.clearance + more + MARGIN, stretch)
    return first_met(places, apart, limits.clearance + cell / 2 + more)


def samples(trajectory: Trajectory, begin: float, end: float) -> Points:
    """Places (n, 3) m along a trajectory from time `begin` to `end`; none when it is over."""
    last = min(end, trajectory.end)
    if last <= begin:
        return np.empty((0, 3))
    return trajectory.sample(np.append(np.arange(begin, last, STEP), last))[0]


def first_met(places: Points, apart: Array, floor: float) -> Walk:
    """The walk along places (n, 3) m, n > 0, that are `apart` (n,) m from the nearest obstacle.

    Nearer than `floor` is too near; a walk that begins too near may leave but not come nearer.
    """
    before = np.concatenate([[apart[0]], np.maximum.accumulate(apart)[:-1]])
    near = np.flatnonzero(apart < np.minimum(floor, before - SLACK))
    least = float(apart.min())
    if len(near) == 0:
        return Walk(None, least)
    steps = np.linalg.norm(np.diff(places[: near[0] + 1], axis=0), axis=1)
    return Walk(float(steps.sum()), least)


def _distances(
    grid: OccupancyGrid, places: Points, reach: float, stretch: float
) -> tuple[Array, float]:
    """m from each place (n, 3) to the nearest occupied cell's centre, inf beyond `reach`, heights
    `stretch` times as long; and the cells' edge."""
    around = np.array([reach, reach, reach / stretch])
    window = grid.window(places.min(axis=0) - around, places.max(axis=0) + around)
    cells = np.argwhere(window.occupied)
    if len(cells) == 0:
        return np.full(len(places), np.inf), window.cell
    scale = np.array([1.0, 1.0, stretch])
    centres = (window.origin_site + (cells + 0.5) * window.cell) * scale
    apart, _ = cKDTree(centres).query(places * scale, distance_upper_bound=reach)
    return np.asarray(apart), window.cell
