"""Where the site frame stands on the earth, and the trees in it."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from .arrays import Array, Points, Vector, frozen
from .terrain import Terrain


class HeightReference(Enum):
    """What a WGS84 height is measured from."""

    ELLIPSOID = "ellipsoid"
    AMSL = "amsl"


@dataclass(frozen=True, slots=True)
class SiteOrigin:
    """The site frame: origin at the first trunk of the first row, +x along the rows at `heading`.

    y is to the left of x, z up from the ground at the origin; metres.
    """

    latitude_deg: float
    longitude_deg: float
    height: float  # m, of the ground at the origin
    height_reference: HeightReference
    heading: float  # rad, compass heading of +x: 0 is north, growing clockwise


@dataclass(frozen=True, slots=True, eq=False)
class TreeRow:
    """One planted row, trees in planting order along +x."""

    trunks_site: Points  # (n, 2) m
    ground: Array  # (n,) m, ground at each trunk above the site origin's ground
    heights: Array  # (n,) m, canopy top above the ground at the trunk

    def __post_init__(self) -> None:
        n = len(self.trunks_site)
        object.__setattr__(self, "trunks_site", frozen(self.trunks_site, (None, 2), "trunks"))
        object.__setattr__(self, "ground", frozen(self.ground, (n,), "ground"))
        object.__setattr__(self, "heights", frozen(self.heights, (n,), "heights"))

    @property
    def canopy_tops_site(self) -> Array:
        """(n,) m, z of each canopy top in the site frame."""
        return self.ground + self.heights


@dataclass(frozen=True, slots=True, eq=False)
class KnownObstacle:
    """A pole, mast or trunk that the crew knows of: an upright cylinder."""

    position_site: Array  # (2,) m
    radius: float  # m
    top: float  # m, z in the site frame
    name: str = "pole"

    def __post_init__(self) -> None:
        object.__setattr__(self, "position_site", frozen(self.position_site, (2,), "position"))


@dataclass(frozen=True, slots=True, eq=False)
class Orchard:
    """What a survey describes: rows of trees, known obstacles and limits on where to fly."""

    name: str
    origin: SiteOrigin
    rows: tuple[TreeRow, ...]
    obstacles: tuple[KnownObstacle, ...] = ()
    fence_site: Points = field(default_factory=lambda: np.empty((0, 2)))  # (n, 2) m; empty: none
    keep_outs_site: tuple[Points, ...] = ()  # each (n, 2) m
    terrain: Terrain | None = None  # None: the ground is known at the trunks alone

    def __post_init__(self) -> None:
        object.__setattr__(self, "fence_site", frozen(self.fence_site, (None, 2), "fence"))
        keep_outs = tuple(frozen(ring, (None, 2), "keep-out") for ring in self.keep_outs_site)
        object.__setattr__(self, "keep_outs_site", keep_outs)

    def ground_near(self, place_site: Vector) -> float:
        """Height of the ground at (2,) m, above the origin's: the terrain's, or, where that is
        not known, that at the nearest trunk."""
        if self.terrain is not None:
            return float(self.terrain.ground(np.asarray(place_site)[None])[0])
        trunks = np.concatenate([row.trunks_site for row in self.rows])
        ground = np.concatenate([row.ground for row in self.rows])
        return float(ground[np.hypot(*(trunks - place_site[:2]).T).argmin()])

    @property
    def canopy_top_site(self) -> float:
        """Highest canopy top, m above the site origin's ground."""
        return max(float(row.canopy_tops_site.max()) for row in self.rows)
