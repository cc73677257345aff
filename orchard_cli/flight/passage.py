"""Which of the mission's waypoints are passed, and which are truly left out."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Points, Vector
from orchard_cli.model.mission import WAYPOINT_PASSED


class Passage:
    """Follows the waypoints in their order, by where the vehicle is.

    One is left out when the next is come to instead, or the route ends. Where rows lie close the
    next waypoint may be within reach before its turn: it counts once it has been out of reach.
    """

    def __init__(self, waypoints_site: Points) -> None:
        self._waypoints = np.asarray(waypoints_site)[:, :2]
        self._due = 0  # index of the next waypoint
        self._apart = False  # the one after it has been out of reach since
        self._reached = np.zeros(len(self._waypoints), dtype=bool)

    def missed(self, position_site: Vector) -> tuple[int, ...]:
        """Numbers (from 1) of the waypoints that are now known to be left out."""
        near = np.linalg.norm(self._waypoints - position_site[:2], axis=1) <= WAYPOINT_PASSED
        self._reached |= near
        here, after = (bool(near[k : k + 1].any()) for k in (self._due, self._due + 1))
        if here or (after and self._apart):
            gone = () if here else (self._due + 1,)
            self._due += 1 if here else 2
            self._apart = False
            return gone
        self._apart = self._apart or not after
        return ()

    def rest(self) -> tuple[int, ...]:
        """Numbers of those that were never come to, when the route is over."""
        gone = tuple(k + 1 for k in range(self._due, len(self._waypoints)) if not self._reached[k])
        self._due = len(self._waypoints)
        return gone
