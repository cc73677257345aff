"""The map seen from above at the height that is kept, for planning in two dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orchard_cli.model.arrays import Vector

T = TypeVar("T", bound=np.generic)


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
            object.__setattr__(self, name, as_input(getattr(self, name), np.bool_))
        object.__setattr__(self, "origin_site", as_input(self.origin_site, np.float64))


def as_input(values: ArrayLike, dtype: type[T]) -> NDArray[T]:
    """A contiguous read-only view (or copy) of an array, of one type for the kernels.

    numba compiles a kernel anew for every kind of array: a writable one here and a read-only or
    sliced one there would stop a flight for a second.
    """
    view = np.ascontiguousarray(values, dtype=dtype).view()
    view.setflags(write=False)
    return view
