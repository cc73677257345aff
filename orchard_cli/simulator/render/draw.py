"""Solids onto the image plane: which pixels each may cover, then ray by ray, nearest first."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchard_cli.geometry.rotations import matrix
from orchard_cli.geometry.shapes import (
    Solids,
    box_bounds,
    capsule_bounds,
    cylinder_bounds,
    spheroid_bounds,
)
from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.depth import DepthCamera

from . import _kernels


@dataclass(frozen=True, slots=True, eq=False)
class Shapes:
    """Solids with the upright boxes around them, ready to be drawn again and again."""

    solids: Solids
    bounds: tuple[tuple[Points, Points], ...]  # lower and upper corners (n, 3), by kind

    @classmethod
    def of(cls, solids: Solids) -> Shapes:
        """Those solids."""
        bounds = (
            cylinder_bounds(solids.cylinders), capsule_bounds(solids.capsules),
            box_bounds(solids.boxes), spheroid_bounds(solids.spheroids),
        )  # fmt: skip
        return cls(solids, bounds)


@dataclass(frozen=True, slots=True, eq=False)
class Painter:
    """A camera at a place in the site frame."""

    camera: DepthCamera
    site_from_camera: Array  # (3, 3)
    position_site: Vector  # (3,) m, of the optical centre
    farthest: float  # m of depth: solids beyond it are not drawn

    @classmethod
    def at(
        cls, camera: DepthCamera, position_site: Vector, site_from_body: Vector, farthest: float
    ) -> Painter:
        """The painter of a camera mounted on a body."""
        turn = matrix(site_from_body)
        lens = np.asarray(position_site, dtype=np.float64) + turn @ camera.position_body
        return cls(camera, turn @ camera.body_from_camera, lens, farthest)

    def paint(self, ground: Array, parts: Iterable[Shapes]) -> NDArray[np.float32]:
        """Nearness (h, w): 1 / depth along the optical axis, 1/m; 0 where there is only sky.

        `ground`: (a, b, c) of the plane z = a x + b y + c.
        """
        camera = self.camera
        u, v = np.arange(camera.width), np.arange(camera.height)
        right, down, ahead = self.site_from_camera.T
        columns = np.float32(right[:, None] * ((u - camera.cx) / camera.fx))
        rows = np.float32(down * ((v - camera.cy) / camera.fy)[:, None] + ahead)
        nearness = np.empty((camera.height, camera.width), dtype=np.float32)
        x, y, z = self.position_site
        below = ground[0] * x + ground[1] * y + ground[2] - z
        _kernels.draw_ground(columns, rows, np.array([ground[0], ground[1], below]), nearness)
        for part in parts:
            for draw, found, (low, high) in zip(
                (_kernels.draw_cylinders, _kernels.draw_capsules, _kernels.draw_boxes,
                 _kernels.draw_spheroids),
                (part.solids.cylinders, part.solids.capsules, part.solids.boxes,
                 part.solids.spheroids),
                part.bounds, strict=True,
            ):  # fmt: skip
                if len(found):
                    windows = self._windows(low, high)
                    draw(columns, rows, windows, found, self.position_site, nearness)
        return nearness

    def _windows(self, low: Points, high: Points) -> NDArray[np.int64]:
        """The pixels (n, 4) that boxes of corners (n, 3) may cover."""
        camera = self.camera
        windows = np.empty((len(low), 4), dtype=np.int64)
        _kernels.find_windows(
            low, high, self.position_site, self.site_from_camera,
            np.array([camera.fx, camera.fy, camera.cx, camera.cy]),
            np.array([camera.width, camera.height]), self.farthest, windows,
        )  # fmt: skip
        return windows
