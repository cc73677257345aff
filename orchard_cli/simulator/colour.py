"""The simulated colour image: plain shading of what the camera's rays meet, and noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.arrays import Array, Vector
from orchard_cli.model.depth import DepthCamera

from .render import Painter
from .scene import Scene

SKY, SOIL, THING = np.array([[170, 195, 225], [150, 130, 100], [70, 75, 65]], dtype=np.float64)
FARTHEST = 60.0  # m
NOISE = 3.0  # grey levels, standard deviation of each channel
GROUND = 0.03  # m: what is less above the ground is the ground
STREAM = 0xC01  # of random numbers, apart from all others


def colour_image(
    scene: Scene,
    camera: DepthCamera,
    position_site: Vector,
    site_from_body: Vector,
    time: float,
    number: int,
) -> NDArray[np.uint8]:
    """(h, w, 3) red, green and blue: things grow darker towards their sides.

    The same for a seed and a `number`.
    """
    painter = Painter.at(camera, position_site, site_from_body, FARTHEST)
    nearness = painter.paint(scene.ground, scene.shapes(time)).astype(np.float64)
    rng = np.random.default_rng([scene.world.seed, STREAM, number])
    image = np.empty((camera.height, camera.width, 3))
    image[:] = SKY
    hit = nearness > 1 / FARTHEST
    above = _above_ground(painter, scene.ground, nearness)
    soil, thing = hit & (above <= GROUND), hit & (above > GROUND)
    image[soil] = SOIL
    image[thing] = THING * _shade(camera, nearness)[thing, None]
    image += NOISE * rng.standard_normal(image.shape)
    shown: NDArray[np.uint8] = np.clip(np.rint(image), 0, 255).astype(np.uint8)
    return shown


def _above_ground(painter: Painter, ground: Array, nearness: Array) -> Array:
    """(h, w) m of each ray's end above the ground z = a x + b y + c."""
    camera = painter.camera
    u = (np.arange(camera.width) - camera.cx) / camera.fx
    v = (np.arange(camera.height) - camera.cy) / camera.fy
    right, down, ahead = painter.site_from_camera.T
    depth = 1 / np.maximum(nearness, 1 / FARTHEST)
    x, y, z = (
        painter.position_site[k] + depth * (right[k] * u + (down[k] * v)[:, None] + ahead[k])
        for k in range(3)
    )
    height: Array = z - (ground[0] * x + ground[1] * y + ground[2])
    return height


def _shade(camera: DepthCamera, nearness: Array) -> Array:
    """(h, w) 0.6 to 1: how squarely a surface faces the camera, from side to side."""
    depth = 1 / np.maximum(nearness, 1 / FARTHEST)
    slope = np.gradient(depth, axis=1) * camera.fx / depth
    shade: Array = 0.6 + 0.4 / np.sqrt(1 + slope**2)
    return shade
