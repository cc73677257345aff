"""The ground as a grid of heights, where a survey's few measured trees do not tell enough."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Array, Indices, Points, Vector, frozen


@dataclass(frozen=True, slots=True, eq=False)
class Terrain:
    """Ground heights on a square grid along the site frame's axes, bilinear between its nodes."""

    corner_site: Vector  # (2,) m, the node of the least x and y
    step: float  # m between nodes
    heights: (
        Array  # (nx, ny) m, z of the ground in the site frame; [i, j] at corner + step * [i, j]
    )

    def __post_init__(self) -> None:
        object.__setattr__(self, "corner_site", frozen(self.corner_site, (2,), "corner"))
        object.__setattr__(self, "heights", frozen(self.heights, (None, None), "heights"))
        if min(self.heights.shape) < 2 or not self.step > 0:
            raise ValueError("terrain: needs two nodes each way, and a step")

    @property
    def far_corner_site(self) -> Vector:
        """(2,) m, the node of the greatest x and y."""
        far: Vector = self.corner_site + self.step * (np.array(self.heights.shape) - 1)
        return far

    def ground(self, places_site: Points) -> Array:
        """z of the ground (n,) m under places (n, 2 or 3); outside the grid that at its edge."""
        parts = [self.heights[i, j] * share for i, j, share in self.nodes(places_site)]
        return np.asarray(np.sum(parts, axis=0))

    def nodes(self, places_site: Points) -> list[tuple[Indices, Indices, Array]]:
        """The four nodes round each place: indices (n,), (n,) and their bilinear share (n,)."""
        last = np.array(self.heights.shape) - 1
        at = (np.asarray(places_site)[:, :2] - self.corner_site) / self.step
        at = np.clip(at, 0.0, last)
        low = np.minimum(at.astype(np.int64), last - 1)
        u, v = (at - low).T
        i, j = low.T
        return [
            (i, j, (1 - u) * (1 - v)),
            (i + 1, j, u * (1 - v)),
            (i, j + 1, (1 - u) * v),
            (i + 1, j + 1, u * v),
        ]
