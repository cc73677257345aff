"""Where the vehicle has been: the way home that is known to be free."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Points, Vector

SPACING = 0.5  # m


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
        """(n, 3) m: from here back to the first point, n >= 2."""
        back = self._points[::-1] or [here_site]
        path = [here_site, *(p for p in back if np.linalg.norm(p - here_site) > SPACING)]
        if len(path) == 1:
            path.append(back[-1] + np.array([0.0, 0.0, 1e-3]))
        return np.stack(path)
