"""Clearance from the map that was built in flight, for flights without a known world."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from orchard_cli.model.flown import FlownLog

from .figures import Figure, Unknown


def map_clearance(log: FlownLog) -> Figure:
    """Smallest distance to the nearest occupied cell, m, from the cell's near side.

    Each map counts from when it was logged to the next one. What the camera never saw is not in
    it, trees are, and noise is: an estimate, where the world gives the truth.
    """
    track = log.odometry
    ends = [later.time for later in log.maps[1:]] + [np.inf]
    smallest = np.inf
    for cells, end in zip(log.maps, ends, strict=True):
        inside = (track.times >= cells.time) & (track.times < end)
        if inside.any() and len(cells.centres_site):
            distance, _ = KDTree(cells.centres_site).query(track.positions_site[inside])
            smallest = min(smallest, float(distance.min()) - cells.cell / 2)
    return smallest if np.isfinite(smallest) else Unknown("the map stayed empty")
