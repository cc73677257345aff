"""Single rays against solids: what a laser rangefinder would truly measure."""

from __future__ import annotations

import numpy as np

from orchard_cli.geometry.shapes import Solids
from orchard_cli.model.arrays import Array, Points

from . import _kernels


def cast(places: Points, directions: Points, reach: float, ground: Array, solids: Solids) -> Array:
    """(k, 3) places and unit directions in the site frame -> (k,) m to the first surface.

    Infinite beyond `reach`. `ground`: (a, b, c) of the plane z = a x + b y + c.
    """
    nearness = np.zeros((len(places), 1, 1), dtype=np.float32)
    still = np.zeros((3, 1), dtype=np.float32)  # one column: the ray is its row alone
    for near, place, direction in zip(nearness, places, directions, strict=True):
        ray = np.asarray(direction, dtype=np.float32)[None]
        below = ground[0] * place[0] + ground[1] * place[1] + ground[2] - place[2]
        _kernels.draw_ground(still, ray, np.array([ground[0], ground[1], below]), near)
        for draw, every in (
            (_kernels.draw_cylinders, solids.cylinders),
            (_kernels.draw_capsules, solids.capsules),
            (_kernels.draw_boxes, solids.boxes),
            (_kernels.draw_spheroids, solids.spheroids),
        ):
            window = np.tile(np.array([0, 1, 0, 1], dtype=np.int64), (len(every), 1))
            draw(still, ray, window, every, place, near)
    found = nearness[:, 0, 0].astype(np.float64)
    ranges = np.full(len(places), np.inf)
    seen = found * reach >= 1.0
    ranges[seen] = 1.0 / found[seen]
    return ranges
