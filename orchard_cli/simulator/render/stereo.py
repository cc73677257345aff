"""The errors of a stereo depth camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.depth import DepthCamera

from . import _kernels

BASELINE = 0.095  # m between the two imagers of a RealSense D455
FARTHEST = 20.0  # m: what is farther has too little disparity to be matched


def stereo_image(
    nearness: NDArray[np.float32],
    camera: DepthCamera,
    disparity_sigma: float,
    dropout: float,
    seed: int,
    frame_number: int,
) -> NDArray[np.uint16]:
    """The image that the camera would send for nearness (h, w): 1 / true depth, 1/m, 0 for sky.

    (h, w) mm along the optical axis, 0 where there is no return: sky, farther than FARTHEST,
    nearer than the camera's range_min, hidden from one imager, or dropped. `disparity_sigma` px is
    the matching error: the depth's error grows with its square. The same seed and frame number
    give the same image.
    """
    image = np.empty(nearness.shape, dtype=np.uint16)
    _kernels.sense(
        nearness, camera.fx * BASELINE, disparity_sigma, dropout, camera.range_min, FARTHEST,
        seed & 0x7FFFFFFF, frame_number & 0x7FFFFFFF, image,
    )  # fmt: skip
    return image
