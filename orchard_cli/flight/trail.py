"""Where the vehicle has been: the way home that is known to be free."""

from __future__ import annotations

import numpy as np
from shapely import LineString

from orchard_cli.model.arrays import Points, Vector
from orchard_cli.motion.fit import rounded

SPACING = 0.5  # m
TOLERANCE = 0.2  # m: the way home may leave the flown one by this much
CORNER_CUT = 0.3  # m


class Trail:
    """Flown positions, one every half metre."""

    def __init__(self) -> None:
        self._points: list[Vector] = []
        self._length = 0.0

    def add(self, position_site: Vector) -> None:
        """Remember (3,) m when it is far enough from the last."""
        if not self._points:
            self._points.append(position_site.copy())
            return
        step = float(np.linalg.norm(position_site - self._points[-1]))
        if step >= SPACING:
            self._points.append(position_site.copy())
            self._length += step

    @property
    def length(self) -> float:
        """Metres flown."""
        return self._length

    def home(self, here_site: Vector) -> Points:
        """(n, 3) m: from here back to the first point, its wiggles straightened by TOLERANCE."""
        back = self._points[::-1] or [here_site]
        path = [here_site, *(p for p in back if np.linalg.norm(p - here_site) > SPACING)]
        if len(path) == 1:
            path.append(back[-1] + np.array([0.0, 0.0, 1e-3]))
        corners = np.array(LineString(path).simplify(TOLERANCE).coords)
        try:
            return rounded(corners, CORNER_CUT).points_site
        except ValueError:  # it once came straight back on its own line: turn there on the spot
            return corners
