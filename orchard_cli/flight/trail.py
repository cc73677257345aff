"""Where the vehicle has been: the way home that is known to be free."""

from __future__ import annotations

import contextlib

import numpy as np

from orchard_cli.model.arrays import Points, Vector
from orchard_cli.motion.fit import rounded
from orchard_cli.motion.straightening import straightened

SPACING = 0.5  # m
TOLERANCE = 0.2  # m: the way home may leave the flown one by this much
CORNER_CUT = 0.3  # m
HAIR = np.array([0.0, 0.0, 1e-3])  # m: a way that is hardly one has a length, and can be timed


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
        """(n, 3) m: from here over the nearest flown point back to the first one."""
        if not self._points:
            return np.stack([here_site, here_site + HAIR])
        points = np.stack(self._points)
        nearest = int(np.argmin(np.linalg.norm(points - here_site, axis=1)))
        path = np.concatenate([here_site[None], points[nearest::-1]])
        corners = straightened(path, TOLERANCE)
        apart = np.linalg.norm(np.diff(corners, axis=0), axis=1) > 1e-3
        corners = np.asarray(corners[np.concatenate([[True], apart])])
        if len(corners) == 1:
            return np.stack([here_site, here_site + HAIR])
        with contextlib.suppress(ValueError):  # straight back on its own line: turn on the spot
            corners = rounded(corners, CORNER_CUT).points_site
        return corners
