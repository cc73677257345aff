"""Where on the route: the path length along the Π that a flight has covered, for every sample."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Array, Points

SPACING = 0.1  # m between places that are tried
BACK, AHEAD = 1.0, 4.0  # m around the last place where the next one is looked for


def places(waypoints_site: Points, positions_site: Points) -> Array:
    """(k, 3) m, (n, 3) m in time order -> (n,) m along the waypoints' polyline, never backwards.

    The nearest place of the whole line would jump to a neighbouring row; here each is looked for
    near the one before, so that two flights are compared where they were at the same place,
    whatever their speed. A flight that turns back keeps the farthest place that it reached.
    """
    corners = np.asarray(waypoints_site, dtype=np.float64)[:, :2]
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    at = np.linspace(0.0, length[-1], int(length[-1] / SPACING) + 2)
    line = np.column_stack([np.interp(at, length, corners[:, i]) for i in range(2)])
    step = at[1] - at[0]
    back, ahead = int(BACK / step), int(AHEAD / step)
    found = np.empty(len(positions_site))
    here = farthest = 0
    for i, (x, y) in enumerate(np.asarray(positions_site)[:, :2]):
        low = max(0, here - back)
        near = line[low : here + ahead + 1]
        here = low + int(((near[:, 0] - x) ** 2 + (near[:, 1] - y) ** 2).argmin())
        farthest = max(farthest, here)
        found[i] = at[farthest]
    return found
