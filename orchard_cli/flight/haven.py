"""Where to come down early: the nearest place on which nothing stands.

A place is free when it is over no tree and no known obstacle, inside the area, and when the map has
seen the column down to the ground to be empty, and the way there at flight height too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.geometry.area import Area
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.mission import Mission

REACH = 6.0  # m
RING = 0.5  # m between the rings of places looked at, with
SPOKES = 24  # places each
CROWN = 0.5  # m of a crown's radius for each metre of a tree's height
SPARE = 0.3  # m beside the airframe
GROUND = 0.4  # m over the ground from which the column must be seen
LEVELS = 8  # heights of the column looked at
SEEN = 0.9  # share of the column's cells that must have been looked at
BAND = 0.5  # m under and over the flight height that must be free on the way
TRIED = 60  # places seen to be empty of which the way there is looked at
_GRID = np.linspace(-1.0, 1.0, 5)
_DISC = np.array([(x, y) for x in _GRID for y in _GRID if math.hypot(x, y) <= 1.0])


@dataclass(frozen=True, slots=True)
class Haven:
    """A place to come down, found from where the vehicle was at a time."""

    place_site: tuple[float, float]  # m
    away: float  # m from there; 0: it may land where it is


class Havens:
    """Knows what stands where, from the survey; the map says the rest."""

    def __init__(self, mission: Mission, area: Area) -> None:
        orchard, radius = mission.orchard, mission.limits.airframe_radius
        trunks = np.concatenate([row.trunks_site for row in orchard.rows])
        crowns = np.concatenate([row.heights for row in orchard.rows]) * CROWN
        known = np.array([(*o.position_site, o.radius) for o in orchard.obstacles]).reshape(-1, 3)
        self._centres = np.concatenate([trunks, known[:, :2]])
        self._keep = np.concatenate([crowns, known[:, 2]]) + radius + SPARE
        self._ground = np.concatenate([row.ground for row in orchard.rows])
        self._area = area
        self._radius = radius + SPARE
        self._clearance = mission.limits.clearance

    def nearest(self, here_site: Vector, grid: OccupancyGrid, cells: Points) -> Haven | None:
        """The nearest free place within REACH of (3,) m; None: there is none that was seen free.

        `cells` (n, 3) m: the map's obstacle cells around here.
        """
        here = np.asarray(here_site, dtype=np.float64)
        places = _around(here[:2])
        apart = np.linalg.norm(places[:, None] - self._centres, axis=2)
        floors = self._ground[apart[:, : len(self._ground)].argmin(axis=1)] + GROUND
        good = (apart >= self._keep).all(axis=1) & (floors < here[2])
        if not self._area.unbounded:
            good &= self._area.margins(places) >= self._radius
        places, floors = places[good], floors[good]
        seen = np.flatnonzero(self._seen(places, floors, float(here[2]), grid))
        for k in seen[:TRIED]:
            if self._free(here, places[k], float(floors[k]), cells):
                x, y = places[k].tolist()
                return Haven((x, y), float(np.linalg.norm(places[k] - here[:2])))
        return None

    def _seen(self, places: Points, floors: Array, top: float, grid: OccupancyGrid) -> Array:
        """(n,) whether the map has looked at the columns over places (n, 2), from floors to top."""
        levels = np.linspace(floors, top, LEVELS, axis=1)
        columns = np.empty((len(places), len(_DISC), LEVELS, 3))
        columns[..., :2] = (places[:, None] + self._radius * _DISC)[:, :, None]
        columns[..., 2] = levels[:, None]
        looked = grid.is_observed(columns.reshape(-1, 3)).reshape(len(places), len(_DISC) * LEVELS)
        return np.asarray(looked.mean(axis=1) >= SEEN)

    def _free(self, here: Vector, place: Vector, floor: float, cells: Points) -> bool:
        """No obstacle cell in the column under the place, nor beside the way there."""
        under = cells[(cells[:, 2] > floor) & (cells[:, 2] < here[2] + BAND), :2] - place
        level = cells[np.abs(cells[:, 2] - here[2]) < BAND, :2] - here[:2]
        way = place - here[:2]
        share = np.clip(level @ way / max(float(way @ way), 1e-9), 0.0, 1.0)
        beside = np.linalg.norm(level - share[:, None] * way, axis=1).min(initial=math.inf)
        standing = np.linalg.norm(level, axis=1).min(initial=math.inf)
        room = min(self._clearance, standing)  # what is near already may not come nearer
        fits = np.linalg.norm(under, axis=1).min(initial=math.inf) > self._radius
        return bool(fits and beside >= room)


def _around(here: Vector) -> Points:
    """Here and rings of places around it, nearest first: (n, 2) m."""
    turns = np.arange(SPOKES) * math.tau / SPOKES
    spokes = np.column_stack([np.cos(turns), np.sin(turns)])
    rings = np.arange(RING, REACH + 1e-9, RING)
    return np.concatenate([here[None], *(here + ring * spokes for ring in rings)])
