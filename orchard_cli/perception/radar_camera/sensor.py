"""Distance, width and height of what radar and camera see together (Huang 2021, §2.2, §2.3)."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from orchard_cli.model.obstacles import Upright
from orchard_cli.model.sensors import ColourFrame, RadarScan, Sensed
from orchard_cli.model.vehicle import Pose

from ..rays import Rays
from .contour import ContourSettings, Outline, opencv, outline
from .spatial import pixels
from .timing import Pair, pair

_KEPT = 16  # newest readings of each sensor


@dataclass(frozen=True, slots=True)
class RadarCameraSettings:
    """What is looked at."""

    trigger: float = 6.0  # m: the set safe distance, at which the image is taken
    apart: float = 0.06  # s between scan and image, at most: half a cycle of a 10 Hz radar
    widest: float = 2.5  # m to either side of a reflection in which its thing is looked for
    highest: float = 4.0  # m above and below
    contour: ContourSettings = field(default_factory=ContourSettings)


class RadarCamera:
    """Fits `Fusion` of avoidance/astar. Remembers the newest readings, and which were used."""

    needs = frozenset({"radar", "colour"})

    def __init__(self, settings: RadarCameraSettings | None = None) -> None:
        opencv()
        self._settings = settings or RadarCameraSettings()
        self._scans: deque[RadarScan] = deque(maxlen=_KEPT)
        self._images: deque[ColourFrame] = deque(maxlen=_KEPT)
        self._used = -math.inf

    def look(self, sensed: Sensed, pose: Pose) -> tuple[Upright, ...]:
        """What the newest pair of readings newly says stands ahead of a body at a pose."""
        if sensed.radar is not None and (
            not self._scans or self._scans[-1].time < sensed.radar.time
        ):
            self._scans.append(sensed.radar)
        if sensed.colour is not None and (
            not self._images or self._images[-1].time < sensed.colour.time
        ):
            self._images.append(sensed.colour)
        s = self._settings
        pairs = pair(self._scans, self._images, s.trigger, s.apart, self._used)
        if not pairs:
            return ()
        self._used = pairs[-1].image.time
        one = measure(pairs[-1], pose, s)
        return () if one is None else (one,)


def measure(found: Pair, pose: Pose, s: RadarCameraSettings) -> Upright | None:
    """The nearest thing: the radar's range, and the contour at its pixel.

    The range is to the surface, the contour's sides are tangents of a round thing: as for
    perception/fusion.py, its radius is ρ sin θ / (1 - sin θ).
    """
    camera, scan = found.image.camera, found.scan
    if not len(scan.returns):
        return None
    seen = pixels(scan, camera)
    inside = (seen[:, 2] > 0.3) & (seen[:, 0] >= 0) & (seen[:, 0] < camera.width)
    if not inside.any():
        return None
    near = int(np.flatnonzero(inside)[np.argmin(seen[inside, 2])])
    u, v, depth = (float(value) for value in seen[near])
    size = (camera.fx * s.widest / depth, camera.fy * s.highest / depth)
    shape = outline(found.image.rgb, u, v, size, s.contour)
    return None if shape is None else _placed(shape, depth, found.image, pose)


def _placed(shape: Outline, depth: float, image: ColourFrame, pose: Pose) -> Upright:
    camera, rays = image.camera, Rays.of(image.camera, pose)
    sides = [math.atan((edge - camera.cx) / camera.fx) for edge in (shape.left, shape.right)]
    half = math.sin((sides[1] - sides[0]) / 2)
    reach = depth / math.cos(sum(sides) / 2)
    radius = reach * half / (1 - half)
    axis = depth + radius
    ends = [rays.position_site + axis * rays.at(shape.middle, row) for row in
            (shape.bottom, shape.top)]  # fmt: skip
    middle = (ends[0] + ends[1])[:2] / 2
    away = float(np.hypot(*(middle - np.asarray(pose.position_site)[:2])))
    return Upright(
        image.time, away - radius, 2 * radius, middle,
        bottom=float(ends[0][2]), top=float(ends[1][2]), cut=shape.cut,
    )  # fmt: skip
