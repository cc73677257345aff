"""The rolling occupancy grid: what the vehicle has seen around itself, and how sure it is."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.vehicle import Pose

from . import _kernels
from .band import Band, as_input
from .insert import InsertReport, View
from .settings import RESOLUTION, GridSettings, stored_log_odds
from .window import Window

_SEEN_FROM = 0.05  # m in front of the lens: cells nearer are not projected
_FADE_EVERY = 1.0  # s between two fadings of a slab
_SLABS = 16  # the grid fades slab by slab, so that no frame pays for the whole of it

Cells = NDArray[np.int64]


class OccupancyGrid:
    """Log-odds of occupancy in cubes around the vehicle; memory is fixed at construction.

    Cells are addressed by their integer site index floor(position / cell). The grid holds the
    indices [lower, lower + size) and forgets what rolls out. Not safe for use by two threads.
    """

    def __init__(self, settings: GridSettings | None = None) -> None:
        self.settings = settings = settings or GridSettings()
        self._size: Cells = np.array(settings.size, dtype=np.int64)
        self._lower: Cells = -(self._size // 2)
        self._log_odds = np.zeros(settings.size, dtype=np.int16)
        self._counts = np.zeros(settings.size, dtype=np.uint8)
        self._touched = np.empty(0, dtype=np.int32)
        self._faded: Array | None = None  # (_SLABS,) s
        self._hit = stored_log_odds(settings.p_hit)
        self._miss = stored_log_odds(settings.p_miss)
        self._free = stored_log_odds(settings.p_free)
        self._certain = stored_log_odds(settings.p_certain)
        self._occupied = stored_log_odds(settings.p_occupied)

    @property
    def lower_site(self) -> Vector:
        """(3,) m, lower corner of the space that the grid holds now."""
        return self._metres(self._lower)

    @property
    def upper_site(self) -> Vector:
        """(3,) m, upper corner of the space that the grid holds now."""
        return self._metres(self._lower + self._size)

    def insert(self, frame: DepthFrame, pose: Pose) -> InsertReport:
        """Take in one depth frame seen from the body's `pose` at the frame's time.

        Rolls to follow the body and fades old evidence. Every pixel within the camera's range
        counts; a cell gets one vote per frame: hit when `min_returns` lie in it, else miss when
        its centre is seen and the nearest return of the pixels there is beyond it. Returns beyond
        range_max carve up to range_max; pixels without a return, or nearer than range_min, say
        nothing. Raises ValueError for a pose that is not finite or a frame of the wrong size.
        """
        camera = frame.camera
        if frame.depth_mm.shape != (camera.height, camera.width):
            raise ValueError(f"depth frame {frame.depth_mm.shape} of another camera")
        view = View.of(camera, pose)
        if not (np.isfinite(view.position_site).all() and np.isfinite(view.site_from_camera).all()):
            raise ValueError("pose: not finite")
        self._follow(np.asarray(pose.position_site))
        self.decay(frame.time)
        depth = as_input(frame.depth_mm, np.uint16)
        touched, returns = self._count_hits(view, depth)
        free = self._carve(view, depth)
        hits = _kernels.vote_hits(
            touched, self.settings.min_returns, self._hit, self._certain,
            self._counts, self._log_odds,
        )  # fmt: skip
        return InsertReport(returns, int(hits), free)

    def decay(self, now: float) -> None:
        """Let unseen evidence fade by the half-life up to `now`; cheap when called often."""
        if self._faded is None:
            self._faded = now - _FADE_EVERY * np.arange(_SLABS) / _SLABS
        age = now - self._faded
        due = np.flatnonzero(age >= _FADE_EVERY)
        if age.max() < 2 * _FADE_EVERY:
            due = due[:2]  # the rest waits for the next call
        for slab in due:
            keep = np.float32(0.5 ** (age[slab] / self.settings.half_life))
            _kernels.fade(self._slab(int(slab)), keep)
            self._faded[slab] = now

    def clear_sphere(self, position_site: Vector, radius: float) -> None:
        """Where the airframe is, is free: set the cells with their centre in the sphere free."""
        box = self._box(np.asarray(position_site) - radius, np.asarray(position_site) + radius)
        _kernels.empty_sphere(
            self._log_odds, box, np.asarray(position_site) / self.settings.cell,
            radius / self.settings.cell, self._free,
        )  # fmt: skip

    def is_occupied(self, points_site: Points) -> NDArray[np.bool_]:
        """(n, 3) -> (n,): whether the cell of each point is an obstacle; outside the grid, no."""
        return np.greater_equal(self._at(points_site), self._occupied)

    def is_observed(self, points_site: Points) -> NDArray[np.bool_]:
        """(n, 3) -> (n,): whether the cell of each point has been seen, free or occupied."""
        return np.not_equal(self._at(points_site), 0)

    def probability(self, points_site: Points) -> Array:
        """(n, 3) -> (n,): how probable an obstacle is in the cell of each point; 0.5: unknown."""
        odds: Array = 1.0 / (1.0 + np.exp(-self._at(points_site) / RESOLUTION))
        return odds

    def occupied_cells(self, centre_site: Vector, radius: float) -> Points:
        """Centres (n, 3) of the obstacle cells within `radius` of a point."""
        centre = np.asarray(centre_site, dtype=np.float64)
        box = self._box(centre - radius, centre + radius)
        found, room = 0, 4096
        out = np.empty((room, 3), dtype=np.int64)
        while True:
            found = _kernels.gather(
                self._log_odds, box, centre / self.settings.cell, radius / self.settings.cell,
                self._occupied, out,
            )  # fmt: skip
            if found <= len(out):
                return self._metres(out[:found] + 0.5)
            out = np.empty((found, 3), dtype=np.int64)

    def band(
        self, centre_site: Vector, half_size: float | tuple[float, float], z_low: float,
        z_high: float,
    ) -> Band:  # fmt: skip
        """A view from above, 2 * half_size wide (along x and along y), of the cells that touch
        [z_low, z_high].

        Columns outside the grid are neither occupied nor observed.
        """
        halves = half_size if isinstance(half_size, tuple) else (half_size, half_size)
        if not (min(halves) > 0 and z_low < z_high):
            raise ValueError("a band needs a positive size and height")
        cell = self.settings.cell
        n = np.array([2 * max(1, round(half / cell)) for half in halves])
        corner = np.round(np.asarray(centre_site)[:2] / cell).astype(np.int64) - n // 2
        occupied = np.zeros(tuple(n), dtype=np.bool_)
        observed = np.zeros(tuple(n), dtype=np.bool_)
        ends = (
            np.append(corner, np.floor(z_low / cell + 1e-9)),
            np.append(corner + n, np.ceil(z_high / cell - 1e-9)),
        )
        _kernels.look_down(
            self._log_odds, corner, self._clipped(*ends), self._occupied, occupied, observed
        )
        return Band(self._metres(corner), cell, occupied, observed, z_low, z_high)

    def window(self, lower_site: Vector, upper_site: Vector) -> Window:
        """The obstacle cells of the box between two corners (3,), which it covers in whole cells.

        Raises ValueError when the upper corner is not above the lower one.
        """
        cell = self.settings.cell
        low = np.floor(np.asarray(lower_site) / cell)
        high = np.ceil(np.asarray(upper_site) / cell)
        if not (high > low).all():
            raise ValueError("a window needs a positive size")
        corner: Cells = low.astype(np.int64)
        occupied = np.zeros(tuple((high - low).astype(np.int64)), dtype=np.bool_)
        box = self._clipped(low, high)
        _kernels.look_into(self._log_odds, corner, box, self._occupied, occupied)
        return Window(self._metres(corner), cell, occupied)

    def _count_hits(self, view: View, depth: NDArray[np.uint16]) -> tuple[NDArray[np.int32], int]:
        """Places of the cells with returns in them, counted in `_counts`, and all returns."""
        camera, cell = view.camera, self.settings.cell
        if self._touched.size < depth.size:
            self._touched = np.empty(depth.size, dtype=np.int32)
        cells, returns = _kernels.count_hits(
            depth, round(1000 * camera.range_min), round(1000 * camera.range_max),
            *view.rays(cell), view.position_site / cell, self._lower, self._size,
            self._counts, self._touched, np.empty(_kernels.STRETCH, dtype=np.int32),
        )  # fmt: skip
        return self._touched[:cells], int(returns)

    def _carve(self, view: View, depth: NDArray[np.uint16]) -> int:
        camera, cell, block = view.camera, self.settings.cell, _kernels.BLOCK
        blocks = np.empty((camera.height // block, camera.width // block), dtype=np.float32)
        _kernels.nearest_blocks(depth, round(1000 * camera.range_min), blocks)
        corners = view.corners()
        return int(
            _kernels.carve(
                blocks, view.block_from_cell(cell, block), view.planes(cell, _SEEN_FROM),
                np.float32(cell * np.sqrt(3) / 2),
                self._box(corners.min(axis=0), corners.max(axis=0)),
                self.settings.min_returns, self._miss, self._free, self._counts, self._log_odds,
            )
        )  # fmt: skip

    def _metres(self, cells: NDArray[Any]) -> Array:
        return cells.astype(np.float64) * self.settings.cell

    def _box(self, low_site: Vector, high_site: Vector) -> Cells:
        """Lower and upper cell indices (6,) of a box of space, clipped to the grid."""
        cell = self.settings.cell
        return self._clipped(np.floor(low_site / cell), np.floor(high_site / cell) + 1)

    def _clipped(self, low: Array, high: Array) -> Cells:
        """The cells [low, high) that the grid holds, as box (6,) for the kernels."""
        first = np.maximum(low.astype(np.int64), self._lower)
        return np.concatenate(
            [first, np.maximum(first, np.minimum(high.astype(np.int64), self._lower + self._size))]
        )

    def _slab(self, slab: int) -> NDArray[np.int16]:
        edges = np.arange(_SLABS + 1) * self.settings.size[0] // _SLABS
        return self._log_odds[edges[slab] : edges[slab + 1]]

    def _at(self, points_site: Points) -> NDArray[np.int16]:
        """Log-odds at points (n, 3); 0 outside the grid."""
        index = np.floor(np.asarray(points_site) / self.settings.cell).astype(np.int64)
        inside = ((index >= self._lower) & (index < self._lower + self._size)).all(axis=1)
        i, j, k = (index & (self._size - 1)).T
        return np.where(inside, self._log_odds[i, j, k], np.int16(0))

    def _follow(self, position_site: Vector) -> None:
        """Roll so that the body is near the middle; what enters is unknown."""
        slack = self.settings.roll_slack / self.settings.cell
        wanted = np.round(position_site / self.settings.cell).astype(np.int64) - self._size // 2
        for axis in range(3):
            moved = int(wanted[axis] - self._lower[axis])
            if abs(moved) <= slack:
                continue
            n = int(self._size[axis])
            first = int(self._lower[axis]) + (n if moved > 0 else moved)
            entering = np.arange(first, first + min(abs(moved), n)) & (n - 1)
            np.moveaxis(self._log_odds, axis, 0)[entering] = 0
            self._lower[axis] = wanted[axis]
