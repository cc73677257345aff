"""Random numbers for something that needs a few of them in every tick."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Array

ROWS = 256  # drawn at a time


class Normals:
    """Standard normal numbers, `width` at a time: the same ones as if drawn one by one."""

    def __init__(self, rng: np.random.Generator, width: int) -> None:
        self._rng = rng
        self._width = width
        self._rows: list[Array] = []

    def next(self) -> Array:
        """(width,)."""
        if not self._rows:
            self._rows = list(self._rng.standard_normal((ROWS, self._width)))[::-1]
        return self._rows.pop()
