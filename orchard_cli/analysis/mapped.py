"""Clearance from the map that was built in flight, for flights without a known world."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from orchard_cli.model.flown import FlownLog
from orchard_cli.model.mission import Mission

from .figures import Figure, Unknown
from .route import Route

LAYER = 1.0  # m above and below the vehicle: what stands there is at flight height
ROUGH = 0.2  # m that a canopy's cells may stand above its surveyed top


def map_clearance(log: FlownLog, mission: Mission, route: Route | Unknown) -> Figure:
    """Smallest distance to the nearest mapped obstacle at flight height on the route, m.

    From the vehicle's centre to the near side of an occupied cell, within LAYER of the vehicle's
    height and above the trees (`_floor`): neither the canopies below nor the ground at landing are
    obstacles. Each map counts from when it was logged to the next one. What the camera never saw is
    not in it, and noise is: an estimate, where the world gives the truth.
    """
    if isinstance(route, Unknown):
        return route
    track, floor = route.track, _floor(mission)
    ends = [later.time for later in log.maps[1:]] + [np.inf]
    smallest = np.inf
    for cells, end in zip(log.maps, ends, strict=True):
        places = track.positions_site[(track.times >= cells.time) & (track.times < end)]
        if not len(places) or not len(cells.centres_site):
            continue
        z = cells.centres_site[:, 2]
        low = max(floor, float(places[:, 2].min()) - LAYER)
        solid = cells.centres_site[(z > low) & (z < float(places[:, 2].max()) + LAYER)]
        if len(solid):
            nearest = KDTree(solid).query(places)[0].min()
            smallest = min(smallest, float(nearest) - cells.cell / 2)
    return smallest if np.isfinite(smallest) else Unknown("the map held nothing at flight height")


def _floor(mission: Mission) -> float:
    """z, m, above which cells are obstacles: the surveyed canopies', or, on a route between the
    trees, just under the airframe."""
    between = float(mission.waypoints_site[:, 2].min()) - mission.limits.airframe_radius
    return min(mission.orchard.canopy_top_site + ROUGH, between)
