"""Where flying is allowed: inside a fence, outside of keep-outs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from orchard_cli.model.arrays import Array, Points


class Area:
    """A fence (n, 2) m, empty for none, and keep-outs, each (k, 2) m; simple polygons."""

    def __init__(self, fence_site: Points, keep_outs_site: Sequence[Points] = ()) -> None:
        self._fence = shapely.Polygon(fence_site) if len(fence_site) else None
        self._keep_outs = tuple(shapely.Polygon(ring) for ring in keep_outs_site)
        for polygon in (self._fence, *self._keep_outs):
            shapely.prepare(polygon)

    @property
    def unbounded(self) -> bool:
        """Whether flying is allowed everywhere."""
        return self._fence is None and not self._keep_outs

    def margins(self, places_site: Points) -> Array:
        """(n, 2) or (n, 3) m -> (n,) m to the nearest edge, negative where flying is forbidden."""
        x, y = places_site[:, 0], places_site[:, 1]
        least = np.full(len(places_site), np.inf)
        polygons = [(self._fence, 1.0)] if self._fence is not None else []
        for polygon, inward in [*polygons, *((ring, -1.0) for ring in self._keep_outs)]:
            inside = np.where(shapely.contains_xy(polygon, x, y), inward, -inward)
            away = shapely.distance(polygon.exterior, shapely.points(x, y))
            least = np.minimum(least, inside * away)
        return least

    def leaves(self, places_site: Points, room: float) -> int | None:
        """Index of the first place (n, 2) or (n, 3) with less than `room` m; None: none has.

        A way that begins with less may lead inwards, but never farther out than it began.
        """
        if self.unbounded or not len(places_site):
            return None
        margins = self.margins(places_site)
        out = np.flatnonzero(margins < min(room, float(margins[0]) - 1e-3))
        return int(out[0]) if len(out) else None
