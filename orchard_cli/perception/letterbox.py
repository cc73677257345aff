"""An image into a network's square, and the network's boxes back into the image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from orchard_cli.model.arrays import Array

GREY = 114 / 255  # of the bars, as YOLO's own training pads


@dataclass(frozen=True, slots=True, eq=False)
class Letterbox:
    """An image scaled to fit, in the middle of a picture of the network's size."""

    picture: NDArray[np.float32]  # (3, height, width) red, green, blue from 0 to 1
    scale: float  # px of the picture in one px of the image
    left: float  # px of the picture left of the image
    top: float  # px above it

    def boxes_image(self, boxes: Array) -> Array:
        """Boxes (n, 4) of left, top, right, bottom in the picture's px, edges at whole numbers ->
        edges in the image's px, where pixel u covers u - 0.5 to u + 0.5."""
        bars = np.array([self.left, self.top, self.left, self.top])
        edges: Array = (boxes - bars) / self.scale - 0.5
        return edges


def letterbox(rgb: NDArray[np.uint8], width: int, height: int) -> Letterbox:
    """Scale an image (h, w, 3) to fit into width x height px, bilinear, and pad it with grey."""
    rows, columns = rgb.shape[:2]
    scale = min(width / columns, height / rows)
    wide, tall = max(1, round(columns * scale)), max(1, round(rows * scale))
    left, top = (width - wide) // 2, (height - tall) // 2
    v = (np.arange(tall) + 0.5) / scale - 0.5
    u = (np.arange(wide) + 0.5) / scale - 0.5
    at = np.meshgrid(v, u, indexing="ij")
    picture = np.full((3, height, width), GREY, dtype=np.float32)
    for k in range(3):
        layer = ndimage.map_coordinates(
            rgb[:, :, k].astype(np.float32), at, order=1, mode="nearest"
        )
        picture[k, top : top + tall, left : left + wide] = layer / 255
    return Letterbox(picture, scale, float(left), float(top))
