"""The rays of a camera's pixels in the site frame (Wang 2020, eq. 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.geometry.rotations import matrix
from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.depth import DepthCamera
from orchard_cli.model.vehicle import Pose


@dataclass(frozen=True, slots=True, eq=False)
class Rays:
    """A camera where it stood when a frame was taken. A ray reaches one metre deep."""

    camera: DepthCamera
    site_from_camera: Array  # (3, 3)
    position_site: Vector  # (3,) m, of the optical centre

    @classmethod
    def of(cls, camera: DepthCamera, pose: Pose) -> Rays:
        """The rays of a camera on a body at a pose."""
        turn = matrix(pose.site_from_body)
        lens = np.asarray(pose.position_site, dtype=np.float64) + turn @ camera.position_body
        return cls(camera, turn @ camera.body_from_camera, lens)

    def at(self, u: float, v: float) -> Vector:
        """(3,) of one pixel: eq. 1 with p_s / f = 1 / fx, turned into the site frame."""
        camera = self.camera
        ray = np.array([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0])
        turned: Vector = self.site_from_camera @ ray
        return turned

    def row_of(self, place_site: Vector) -> float:
        """Row, px, at which a place (3,) before the camera is seen."""
        x, y, z = (place_site - self.position_site) @ self.site_from_camera
        del x
        return float(self.camera.cy + self.camera.fy * y / max(z, 0.1))

    def grid(self, block: int) -> tuple[Array, Points]:
        """A part per column (3, w) and one per row (h, 3), whose sums are the rays of the centres
        of blocks of pixels."""
        camera = self.camera
        u = block * np.arange(camera.width // block) + (block - 1) / 2
        v = block * np.arange(camera.height // block) + (block - 1) / 2
        right, down, ahead = self.site_from_camera.T
        columns = right[:, None] * ((u - camera.cx) / camera.fx)
        rows = down * ((v - camera.cy) / camera.fy)[:, None] + ahead
        return np.ascontiguousarray(columns), np.ascontiguousarray(rows)
