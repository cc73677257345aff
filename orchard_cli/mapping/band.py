"""The map seen from above at the height that is kept, for planning in two dimensions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.arrays import Vector


@dataclass(frozen=True, slots=True, eq=False)
class Band:
    """A horizontal slice of the grid. Cell [ix, iy] spans origin + cell * (ix .. ix + 1, iy ..)."""

    origin_site: Vector  # (2,) m, lower left corner of cell [0, 0]
    cell: float  # m
    occupied: NDArray[np.bool_]  # (nx, ny) C-contiguous: any cell of the column is an obstacle
    observed: NDArray[np.bool_]  # (nx, ny): any cell of the column was ever seen
    z_low: float  # m
    z_high: float  # m

    def __post_init__(self) -> None:
        if self.occupied.shape != self.observed.shape or self.occupied.ndim != 2:
            raise ValueError("a band's two layers are of one shape")
        for name in ("occupied", "observed"):
            layer = np.ascontiguousarray(getattr(self, name), dtype=np.bool_)
            layer.setflags(write=False)
            object.__setattr__(self, name, layer)
