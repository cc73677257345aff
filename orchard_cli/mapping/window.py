"""A box of the map in three dimensions, for planning that may also go over and under."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.arrays import Vector

from .band import as_input


@dataclass(frozen=True, slots=True, eq=False)
class Window:
    """Obstacle cells of a box. Cell [i, j, k] spans origin + cell * (i .. i + 1, j .., k ..).

    What the grid does not hold, or has not seen, is no obstacle.
    """

    origin_site: Vector  # (3,) m, lower corner of cell [0, 0, 0]
    cell: float  # m
    occupied: NDArray[np.bool_]  # (nx, ny, nz) C-contiguous

    def __post_init__(self) -> None:
        if self.occupied.ndim != 3:
            raise ValueError(f"window {self.occupied.shape}: expected three dimensions")
        object.__setattr__(self, "occupied", as_input(self.occupied, np.bool_))
        object.__setattr__(self, "origin_site", as_input(self.origin_site, np.float64))
