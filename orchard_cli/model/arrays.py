"""Array types of the nouns, and the one way to freeze an array."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
"""Any float array; its shape and unit are written on the field's line."""

Points = NDArray[np.float64]
"""(n, 2) or (n, 3) positions, metres."""

Indices = NDArray[np.integer[Any]]
"""(n,) whole numbers: places in another array, or labels."""

Vector = NDArray[np.float64]
"""(2,), (3,) or (4,)."""


def frozen(values: ArrayLike, shape: tuple[int | None, ...], what: str) -> NDArray[np.float64]:
    """Copy to a read-only float64 array of the given shape (None: any length), finite throughout.

    Raises ValueError naming `what` when the shape is wrong or a value is not finite.
    """
    array: NDArray[Any] = np.array(values, dtype=np.float64)
    if array.ndim != len(shape) or any(
        want is not None and got != want for got, want in zip(array.shape, shape, strict=True)
    ):
        wanted = "x".join("n" if want is None else str(want) for want in shape)
        raise ValueError(f"{what}: shape {array.shape}, expected {wanted}")
    if not np.isfinite(array).all():
        raise ValueError(f"{what}: not finite")
    array.setflags(write=False)
    return array
