"""From the radar to the pixel: spatial fusion (Huang 2021, §2.2.1, eqs. 1-4).

The equations are lost in our text; they are written here from what it says of them. Its vehicle's
frame has y along the nose, x to the right and z up, and radar and camera stand on its y-z plane at
heights Hu, Hr, Hc and distances Lr, Lc. Here the body's x runs along the nose and y to the left:

1. eq. 1, radar to world: (Rr sin α, Rr cos α, Hr) becomes RadarScan.points_body, with the elevation
   that our radar measures, too;
2. eq. 2, world to pixel: Z (u, v, 1) = M1 M2 (x, y, z, 1), M1 of f/dx, f/dy, u0, v0 and M2 of R, T;
3. eq. 3 is one put into the other: `pixels`;
4. eq. 4, the radar's place as the camera sees it: Tr - Tc, here `offset`.
"""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.depth import DepthCamera
from orchard_cli.model.sensors import Radar, RadarScan


def intrinsic(camera: DepthCamera) -> Array:
    """M1 (3, 3), px: f/dx, f/dy, u0, v0 (eq. 2)."""
    return np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])


def extrinsic(camera: DepthCamera) -> Array:
    """M2 (3, 4): camera from body (eq. 2)."""
    turn = np.asarray(camera.body_from_camera).T
    return np.column_stack([turn, -turn @ camera.position_body])


def offset(radar: Radar, camera: DepthCamera) -> Vector:
    """(3,) m in the body frame: Tr - Tc, from the camera to the radar (eq. 4)."""
    moved: Vector = radar.position_body - camera.position_body
    return moved


def pixels(scan: RadarScan, camera: DepthCamera) -> Points:
    """(n, 3) of each reflection: column and row, px, and depth along the optical axis, m (eq. 3).

    Column and row are NaN for what lies behind the camera.
    """
    points = np.column_stack([scan.points_body, np.ones(len(scan.returns))])
    seen = points @ extrinsic(camera).T @ intrinsic(camera).T
    depth = seen[:, 2]
    ahead = np.where(depth > 1e-6, depth, np.nan)
    placed: Points = np.column_stack([seen[:, 0] / ahead, seen[:, 1] / ahead, depth])
    return placed
