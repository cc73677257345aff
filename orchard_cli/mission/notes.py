"""What a pilot should know of a mission that may fly."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Points
from orchard_cli.model.mission import Mission

from .checks import flown

_BENT = 1.0  # m off the straight line between a row's ends: rows that bend more are named


def notes(mission: Mission) -> tuple[str, ...]:
    """Known obstacles that the flight will have to avoid, and rows that it does not follow."""
    return (*_obstacles(mission), *_bends(mission))


def _bow(places: Points) -> float:
    """Greatest distance of places (n, 2) m from the straight line between the first and last, m."""
    way, off = places[-1] - places[0], places - places[0]
    across = off[:, 0] * way[1] - off[:, 1] * way[0]
    return float(np.abs(across).max() / max(float(np.hypot(*way)), 1e-9))


def _bends(mission: Mission) -> list[str]:
    """Each line is straight, from its row's first tree to the last."""
    bent = [(_bow(row.trunks_site), k) for k, row in enumerate(mission.orchard.rows, 1)]
    bent = [(off, k) for off, k in bent if off > _BENT]
    if not bent:
        return []
    worst, row = max(bent)
    return [
        f"{len(bent)} of {len(mission.orchard.rows)} rows bend by more than {_BENT:g} m, row {row} "
        f"by {worst:.1f} m: they are flown STRAIGHT from the first tree to the last, and trees "
        "beside that line get less; split such rows in two"
    ]


def _obstacles(mission: Mission) -> list[str]:
    path = flown(mission)
    found = []
    for obstacle in mission.orchard.obstacles:
        apart = np.hypot(*(path[:, :2] - obstacle.position_site).T) - obstacle.radius
        low = path[:, 2] < obstacle.top + mission.limits.clearance
        gap = apart[low].min(initial=np.inf)
        if gap < mission.limits.clearance:
            x, y = obstacle.position_site
            found.append(
                f"{obstacle.name} at ({x:g}, {y:g}) stands {max(gap, 0):.2f} m from the route; "
                "it will be avoided in flight"
            )
    return found
