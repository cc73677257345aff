"""The depth camera and its frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .arrays import Array, Indices, Points, Vector, frozen


@dataclass(frozen=True, slots=True, eq=False)
class DepthCamera:
    """A pinhole depth camera on the body (Liu 2024, eqs. 1-2).

    Camera frame: x right, y down, z along the optical axis. Pixel (u, v) is column, row; its
    centre is at (u, v), so a ray is ((u - cx) / fx, (v - cy) / fy, 1).
    """

    width: int
    height: int
    fx: float  # px
    fy: float  # px
    cx: float  # px
    cy: float  # px
    range_min: float  # m along the optical axis, nearer returns are not trusted
    range_max: float  # m along the optical axis, farther returns are not trusted
    body_from_camera: Array  # (3, 3) rotation
    position_body: Vector  # (3,) m

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "body_from_camera", frozen(self.body_from_camera, (3, 3), "body_from_camera")
        )
        object.__setattr__(self, "position_body", frozen(self.position_body, (3,), "position"))

    def points(self, u: Indices, v: Indices, depth: Array) -> Points:
        """Where pixels (n,) columns and rows with depths (n,) m are: (n, 3) m, camera frame."""
        return np.column_stack(
            [(u - self.cx) / self.fx * depth, (v - self.cy) / self.fy * depth, depth]
        )


FORWARD = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""body_from_camera of a camera that looks along the nose, level."""


def d455(width: int = 848, height: int = 480) -> DepthCamera:
    """The RealSense D455's depth stream: 87° x 58°, 0.6 to 6 m (Liu 2024, §6.1).

    Raises ValueError for a mode that the camera has not.
    """
    if (width, height) not in ((848, 480), (640, 480), (424, 240), (212, 120)):
        raise ValueError(f"no D455 depth mode {width}x{height}")
    fx = 848 / 2 / np.tan(np.radians(87.0) / 2) * (height / 480)
    return DepthCamera(
        width, height, fx, fx, (width - 1) / 2, (height - 1) / 2, 0.6, 6.0,
        FORWARD, np.array([0.1, 0.0, 0.0]),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class DepthFrame:
    """One depth image. 0 means no return: sky, a hole, or out of range."""

    time: float  # s, flight clock, middle of the exposure
    depth_mm: NDArray[np.uint16]  # (height, width) along the optical axis
    camera: DepthCamera
