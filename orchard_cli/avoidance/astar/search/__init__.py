"""The improved A* of Huang et al. 2021, §2.4, beside the plain one, in two and three dimensions.

Eq. 7 lost its formula in print; its text asks for a weight of h(n) that is large far from the
target and falls towards it, from R, the distance from start to target, and r, that from here:
f(n) = g(n) + (1 + r / R) h(n), which is 2 at the start and 1 at the target. Of Table 2 the numbers
are lost, too: the four of eight directions that are kept lie within 90° of the line to the target.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _kernels

Cells = NDArray[np.int32]
Blocked = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Variant:
    """Which of the paper's three steps are taken."""

    dynamic: bool = True  # eq. 7 instead of eq. 6
    pruned: bool = True  # §2.4.2: half of the directions, with the fall-back of Fig. 5b
    straight: bool = True  # §2.4.3: only start, end and key turning points


PLAIN = Variant(dynamic=False, pruned=False, straight=False)
DYNAMIC = Variant(pruned=False, straight=False)
PRUNED = Variant(straight=False)
IMPROVED = Variant()


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """A way from start to goal over free cells."""

    cells: Cells  # (n, d) indices; straight lines between them touch free cells only
    expanded: int  # cells taken from the open list

    @property
    def length(self) -> float:
        """In cells."""
        return float(np.linalg.norm(np.diff(self.cells, axis=0), axis=1).sum())

    @property
    def turns(self) -> int:
        """How often the direction changes."""
        legs = np.diff(self.cells, axis=0).astype(np.float64)
        legs /= np.linalg.norm(legs, axis=1, keepdims=True)
        return int((np.abs(np.diff(legs, axis=0)).max(axis=1) > 1e-9).sum()) if len(legs) else 0


@dataclass(frozen=True, slots=True)
class NoWay:
    """There is none."""

    expanded: int


_REACH = 3  # points looked past the last one seen
_STEPS = np.array([step for step in product((-1, 0, 1), repeat=3) if any(step)], dtype=np.int32)
_LEVEL = _STEPS[_STEPS[:, 2] == 0]
_LENGTHS = {len(steps): np.sqrt((steps**2).sum(axis=1)) for steps in (_STEPS, _LEVEL)}


@dataclass(slots=True, eq=False)
class Searcher:
    """Searches grids of any size; keeps its tables between calls, so that none need be cleared."""

    _run: int = 0
    _stamp: NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, np.int32))
    _cost: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    _parents: NDArray[np.int32] = field(default_factory=lambda: np.empty(0, np.int32))
    _keys: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    _heap: NDArray[np.int32] = field(default_factory=lambda: np.empty(0, np.int32))
    _path: Cells = field(default_factory=lambda: np.empty((0, 3), np.int32))
    _way: Cells = field(default_factory=lambda: np.empty((0, 3), np.int32))

    def search(
        self, blocked: Blocked, start: Cells, goal: Cells, variant: Variant = IMPROVED
    ) -> Way | NoWay:
        """The way from cell `start` to cell `goal` (d,) of a grid with d = 2 or 3 axes.

        Steps go to 8 or 26 neighbours and cut no corner of a blocked cell. Raises ValueError for a
        start or goal outside the grid.
        """
        dimensions = blocked.ndim
        asked = self.prepared(blocked, start, goal, variant)
        if asked is None:
            return NoWay(0)
        length, expanded = _kernels.find_way(*asked)
        if length == 0:
            return NoWay(expanded)
        return Way(self._way[:length, :dimensions].copy(), expanded)

    def prepared(
        self, blocked: Blocked, start: Cells, goal: Cells, variant: Variant, runs: int = 1
    ) -> tuple[Any, ...] | None:
        """What the kernel `find_way` takes, for `runs` calls; None when an end is blocked."""
        dimensions = blocked.ndim
        if dimensions not in (2, 3):
            raise ValueError(f"a grid has 2 or 3 axes, not {dimensions}")
        solid = np.ascontiguousarray(blocked if dimensions == 3 else blocked[:, :, None])
        ends = np.zeros((2, 3), dtype=np.int64)
        ends[:, :dimensions] = start, goal
        if (ends < 0).any() or (ends >= solid.shape).any():
            raise ValueError("start or goal lies outside the grid")
        if solid[tuple(ends[0])] or solid[tuple(ends[1])]:
            return None
        steps = _STEPS if dimensions == 3 else _LEVEL
        self._make_room(solid.size, len(steps))
        first, self._run = self._run + 1, self._run + 2 * runs  # each may try twice
        return (
            solid, steps, _LENGTHS[len(steps)], ends[0], ends[1], variant.dynamic, variant.pruned,
            _REACH if variant.straight else 0, first, self._stamp, self._cost, self._parents,
            self._keys, self._heap, self._path, self._way,
        )  # fmt: skip

    def _make_room(self, cells: int, steps: int) -> None:
        if self._stamp.size < cells:
            self._run = 0
            self._stamp = np.zeros(cells, np.int32)
            self._cost = np.empty(cells)
            self._parents = np.empty(cells, np.int32)
            self._path = np.empty((cells, 3), np.int32)
            self._way = np.empty((cells, 3), np.int32)
        if self._heap.size < cells * steps + 1:
            self._keys = np.empty(cells * steps + 1)
            self._heap = np.empty(cells * steps + 1, np.int32)
