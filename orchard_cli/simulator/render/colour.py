"""What a colour camera sees: plain colours by kind, lit from one side. No photograph."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.arrays import Array

from .draw import Painter, Shapes

SOIL, LEAVES, TIMBER, METAL, PLASTER, CLOTHES = range(6)
COLOURS = np.array(
    [[134, 112, 80], [58, 110, 44], [120, 96, 70], [70, 70, 78], [190, 184, 172], [200, 72, 48]],
    dtype=np.float32,
)
"""Red, green, blue of each kind in full light."""

SKY = np.array([168, 196, 226], dtype=np.float32)
SUN = np.array([0.4, -0.5, 0.77])  # towards it, site frame
SHADE = 0.45  # brightness of what is turned away
GRAIN = np.array([10.0, 22.0, 5.0, 3.0, 4.0, 5.0], dtype=np.float32)  # of each kind's surface
NOISE = 2.0  # of the sensor


def colour_image(
    painter: Painter, ground: Array, layers: Sequence[Iterable[Shapes]], seed: int, number: int
) -> NDArray[np.uint8]:
    """Red, green and blue (h, w, 3): `layers` are what is made of LEAVES, TIMBER and so on.

    The same seed and number give the same image.
    """
    painted = np.stack(
        [painter.paint(ground, ()), *(painter.paint(ground, layer) for layer in layers)]
    )
    kinds = painted.argmax(axis=0)  # of equals the first: the ground
    nearness = painted.max(axis=0)
    random = np.random.default_rng([seed, number])
    shape = (*nearness.shape, 1)
    grain = GRAIN[kinds][..., None] * random.standard_normal(shape, dtype=np.float32)
    light = _light(painter, nearness)[..., None]
    rgb = np.where(nearness[..., None] > 0, COLOURS[kinds] * light + grain, SKY)
    rgb += NOISE * random.standard_normal(rgb.shape, dtype=np.float32)
    return np.clip(rgb, 0, 255).astype(np.uint8)


def _light(painter: Painter, nearness: NDArray[np.float32]) -> NDArray[np.float32]:
    """(h, w): how bright a surface is, by the way it faces."""
    camera = painter.camera
    depth = 1.0 / np.maximum(nearness, 1e-3)
    x = depth * ((np.arange(camera.width) - camera.cx) / camera.fx).astype(np.float32)
    y = depth * ((np.arange(camera.height) - camera.cy) / camera.fy).astype(np.float32)[:, None]
    points = np.stack([x, y, depth], axis=-1)
    across, down = np.gradient(points, axis=1), np.gradient(points, axis=0)
    normals = np.cross(down, across)  # towards the camera
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-9)
    facing = np.maximum(normals @ (painter.site_from_camera.T @ SUN), 0.0)
    lit: NDArray[np.float32] = (SHADE + (1 - SHADE) * facing).astype(np.float32)
    return lit
