"""Solids onto the image plane: which pixels each may cover, then ray by ray, nearest first."""

from __future__ import annotations

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
from orchard_cli.model.arrays import Array, Vector
from orchard_cli.model.depth import DepthCamera

from . import _kernels

_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
_EDGES = np.array([(a, b) for a in range(8) for b in range(a) if (a ^ b) in (1, 2, 4)])


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

    def paint(self, ground: Array, solids: Solids) -> NDArray[np.float32]:
        """True depth (h, w) m along the optical axis, infinity where there is only sky.

        `ground`: (a, b, c) of the plane z = a x + b y + c.
        """
        camera = self.camera
        u, v = np.arange(camera.width), np.arange(camera.height)
        right, down, ahead = self.site_from_camera.T
        columns = right[:, None] * ((u - camera.cx) / camera.fx)
        rows = down * ((v - camera.cy) / camera.fy)[:, None] + ahead
        depth = np.empty((camera.height, camera.width), dtype=np.float32)
        x, y, z = self.position_site
        below = ground[0] * x + ground[1] * y + ground[2] - z
        _kernels.draw_ground(columns, rows, np.array([ground[0], ground[1], below]), depth)
        for draw, extent, rows_of in (
            (_kernels.draw_cylinders, cylinder_bounds, solids.cylinders),
            (_kernels.draw_capsules, capsule_bounds, solids.capsules),
            (_kernels.draw_boxes, box_bounds, solids.boxes),
            (_kernels.draw_spheroids, spheroid_bounds, solids.spheroids),
        ):
            order, windows = self._windows(*extent(rows_of))
            draw(columns, rows, windows, rows_of[order], self.position_site, depth)
        return depth

    def _windows(self, low: Array, high: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Which boxes, of corners (n, 3) in the site frame, are in view, nearest first, and the
        pixels (k, 4) that they may cover.

        Boxes are cut at the near plane: what lies behind the camera covers nothing.
        """
        camera, near = self.camera, _kernels.NEAR
        corners = low[:, None] + _CORNERS * (high - low)[:, None]
        corners = (corners - self.position_site) @ self.site_from_camera  # (n, 8, 3), camera frame
        a, b = corners[:, _EDGES[:, 0]], corners[:, _EDGES[:, 1]]
        crosses = ((a[..., 2] < near) != (b[..., 2] < near))[..., None]
        share = (near - a[..., 2:]) / np.where(crosses, b[..., 2:] - a[..., 2:], 1.0)
        cut = np.where(crosses, a + share * (b - a), np.array([0.0, 0.0, -1.0]))
        points = np.concatenate([corners, cut], axis=1)
        ahead = points[..., 2] >= near * (1 - 1e-9)
        z = np.where(ahead, points[..., 2], 1.0)
        edges = []
        for along, focal, centre, size in (
            (points[..., 0], camera.fx, camera.cx, camera.width),
            (points[..., 1], camera.fy, camera.cy, camera.height),
        ):
            pixel = focal * along / z + centre
            first = np.where(ahead, pixel, np.inf).min(axis=1)
            last = np.where(ahead, pixel, -np.inf).max(axis=1)
            edges += [np.clip(np.ceil(first), 0, size), np.clip(np.floor(last) + 1, 0, size)]
        windows = np.stack(edges, axis=1).astype(np.int64)
        nearest = corners[..., 2].min(axis=1)
        seen = (windows[:, 0] < windows[:, 1]) & (windows[:, 2] < windows[:, 3])
        order = np.flatnonzero(seen & (nearest < self.farthest))
        order = order[np.argsort(nearest[order], kind="stable")]
        return order, windows[order]
