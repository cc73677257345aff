"""From a depth frame and its pose to the view that the kernels walk (Liu 2024, eqs. 1-8).

The paper prints eq. 8 as P_w = R^-1 P_c - t. That contradicts its eq. 7 (P_c = R P_w + t), whose
inverse is P_w = R^-1 (P_c - t); the latter is what stands here, with R^-1 = site_from_camera and
-R^-1 t = the camera's position.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchard_cli.geometry.rotations import matrix
from orchard_cli.model.arrays import Array, Vector
from orchard_cli.model.depth import DepthCamera
from orchard_cli.model.vehicle import Pose


@dataclass(frozen=True, slots=True)
class InsertReport:
    """What one frame did to the grid."""

    returns: int  # pixels that returned within the camera's range and the grid
    hit_cells: int
    free_cells: int


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """Where the camera stood and looked when the frame was taken."""

    camera: DepthCamera
    site_from_camera: Array  # (3, 3)
    position_site: Vector  # (3,) m, of the optical centre

    @classmethod
    def of(cls, camera: DepthCamera, pose: Pose) -> View:
        """The view of a camera mounted on a body at a pose."""
        site_from_body = matrix(pose.site_from_body)
        position = np.asarray(pose.position_site) + site_from_body @ camera.position_body
        return cls(camera, site_from_body @ camera.body_from_camera, position)

    def rays(self, cell: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Cells travelled per millimetre of depth: a part per column (3, w) and per row (h, 3).

        The ray of pixel (u, v) is their sum: eqs. 4 and 5 times the rotation of eq. 8.
        """
        camera = self.camera
        x = (np.arange(camera.width) - camera.cx) / camera.fx
        y = (np.arange(camera.height) - camera.cy) / camera.fy
        right, down, ahead = self.site_from_camera.T / (1000.0 * cell)
        return (
            (right[:, None] * x).astype(np.float32),
            (down * y[:, None] + ahead).astype(np.float32),
        )

    def camera_from_cell(self, cell: float) -> Array:
        """(3, 4): (i, j, k, 1) of a cell to its centre in the camera frame, m."""
        camera_from_site = self.site_from_camera.T
        offset = camera_from_site @ (0.5 * cell - self.position_site)
        return np.column_stack([camera_from_site * cell, offset])

    def block_from_cell(self, cell: float, block: int) -> Array:
        """(3, 4): (i, j, k, 1) of a cell to (column * z, row * z, z) in blocks of pixels and m.

        Eqs. 3 and 7; pixel u covers u - 0.5 to u + 0.5, so block 0 begins at pixel -0.5.
        """
        camera = self.camera
        intrinsics = np.array(
            [
                [camera.fx / block, 0.0, (camera.cx + 0.5) / block],
                [0.0, camera.fy / block, (camera.cy + 0.5) / block],
                [0.0, 0.0, 1.0],
            ]
        )
        return intrinsics @ self.camera_from_cell(cell)

    def planes(self, cell: float, near: float) -> Array:
        """(6, 4): the view pyramid; `planes @ (i, j, k, 1) >= 0` for the cells inside."""
        camera = self.camera
        left, right = ((edge - camera.cx) / camera.fx for edge in (-0.5, camera.width - 0.5))
        top, bottom = ((edge - camera.cy) / camera.fy for edge in (-0.5, camera.height - 0.5))
        normals = np.array(
            [[0, 0, 1], [0, 0, -1], [1, 0, -left], [-1, 0, right], [0, 1, -top], [0, -1, bottom]]
        )
        planes = normals @ self.camera_from_cell(cell)
        planes[0, 3] -= near
        planes[1, 3] += camera.range_max
        return planes

    def corners(self) -> Array:
        """(5, 3) m: the camera and the far corners of what it sees, in the site frame."""
        camera = self.camera
        x = np.array([-0.5, camera.width - 0.5] * 2)
        y = np.array([-0.5, -0.5, camera.height - 0.5, camera.height - 0.5])
        rays = np.stack([(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, np.ones(4)])
        far = self.position_site + camera.range_max * (self.site_from_camera @ rays).T
        return np.vstack([self.position_site, far])
