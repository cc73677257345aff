"""A detector that needs no weights: surfaces of the depth image, judged by size and shape.

Fits perception/eyes.py `Detector`. It sees what stands out from the ground; what touches in the
image and in depth is one thing to it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from orchard_cli.mapping.band import as_input
from orchard_cli.model.arrays import Array, Vector
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.obstacles import Detection
from orchard_cli.model.sensors import ColourFrame
from orchard_cli.model.vehicle import Pose

from . import _kernels
from .distance import Distance, Rule
from .fusion import fuse
from .rays import Rays
from .shapes import Shape, ShapeRules, breadth, judge, moments, principal


@dataclass(frozen=True, slots=True)
class DepthDetectorSettings:
    """How surfaces are told apart. The camera's errors are those of a RealSense D455."""

    far: float = 10.0  # m along the optical axis: surfaces beyond are not looked at
    widest: int = 424  # px: larger images are shrunk to at most this, nearest surface first
    gap: float = 0.2  # m of depth between neighbours of one surface: leaves
    disparity: float = 0.1  # px, the stereo pair's error
    baseline: float = 0.095  # m between the pair
    noises: float = 1.3  # times the camera's error that neighbours may differ besides
    ground: tuple[float, float, float] = (0.0, 0.0, 0.0)  # z = a x + b y + c of the site frame
    above_ground: float = 0.25  # m that count as ground
    slack: float = 0.02  # m more for each metre away: errors of attitude
    least: int = 12  # px of a shrunk image that make a surface
    friends: int = 2  # neighbours of eight without which a pixel is a ghost
    rules: ShapeRules = field(default=ShapeRules())


class DepthDetector:
    """Cuts a depth image into surfaces and names each by its shape."""

    needs: frozenset[str] = frozenset()

    def __init__(self, settings: DepthDetectorSettings | None = None) -> None:
        self.settings = settings or DepthDetectorSettings()

    def detect(
        self, frame: DepthFrame, pose: Pose, colour: ColourFrame | None
    ) -> tuple[Detection, ...]:
        """What stands in view, nearest first; colour is not looked at."""
        del colour
        s, camera = self.settings, frame.camera
        block = max(1, -(-camera.width // s.widest))
        growth = s.noises * s.disparity / (camera.fx * s.baseline)
        rays = Rays.of(camera, pose)
        columns, rows = rays.grid(block)
        depth = self._surfaces(frame, rays, columns, rows, block, growth)
        labels = np.empty(depth.shape, dtype=np.int32)
        parent = np.empty(depth.size, dtype=np.int64)
        count = _kernels.label(depth, s.gap, growth, parent, labels)
        found = np.empty((count, _kernels.FEATURES))
        _kernels.measure(depth, labels, columns, rows, s.gap, growth, found)
        found = found[found[:, _kernels.COUNT] >= s.least]
        found = found[np.argsort(found[:, _kernels.NEAREST], kind="stable")]
        return tuple(self._detection(row, rays, block, depth.shape) for row in found)

    def _surfaces(
        self, frame: DepthFrame, rays: Rays, columns: Array, rows: Array, block: int, growth: float
    ) -> Array:
        """Depth (h, w) m, shrunk, without ground and ghosts; 0 is nothing."""
        s, camera = self.settings, frame.camera
        small = np.empty((camera.height // block, camera.width // block))
        _kernels.shrink(
            as_input(frame.depth_mm, np.uint16), block, camera.range_min, s.far, s.gap, growth,
            small,
        )  # fmt: skip
        _kernels.drop_ground(
            small, columns, rows, rays.position_site, np.array(s.ground), s.above_ground, s.slack
        )
        kept = np.empty_like(small)
        _kernels.drop_lonely(small, s.gap, growth, s.friends, kept)
        return kept

    def _detection(self, row: Vector, rays: Rays, block: int, shape: tuple[int, ...]) -> Detection:
        s, count = self.settings, float(row[_kernels.COUNT])
        centre, covariance = moments(row[_kernels.SUMS : _kernels.SUMS + 9], count)
        spreads, axes = principal(covariance)
        left, right, top, bottom = row[_kernels.LEFT : _kernels.BOTTOM + 1]
        z = max(float(centre @ rays.site_from_camera[:, 2]), rays.camera.range_min)
        place = rays.position_site + centre
        ground = float(s.ground[0] * place[0] + s.ground[1] * place[1] + s.ground[2])
        level = float(rays.position_site[2]) - ground
        edge = left == 0 or top == 0 or right == shape[1] - 1 or bottom == shape[0] - 1
        behind = row[_kernels.HIDDEN_LEFT : _kernels.HIDDEN_BOTTOM + 1].max()
        seen = Shape(
            width=min(
                float(right - left + 1) * block * z / rays.camera.fx, breadth(centre, covariance)
            ),
            bottom=level + float(row[_kernels.LOWEST]),
            top=level + float(row[_kernels.HIGHEST]),
            spreads=spreads,
            axis_up=abs(float(axes[2, 0])),
            normal_up=abs(float(axes[2, 2])),
            hidden=bool(edge or behind >= max(3, 0.2 * min(right - left, bottom - top))),
            noise=z**2 * s.disparity / (rays.camera.fx * s.baseline),
        )
        found = Detection(
            judge(seen, s.rules),
            count / (count + s.least),
            float(left * block) - 0.5,
            float(top * block) - 0.5,
            float((right + 1) * block) - 0.5,
            float((bottom + 1) * block) - 0.5,
            float(row[_kernels.NEAREST]) - s.gap,
            float(row[_kernels.FARTHEST]) + s.gap,
        )
        if seen.bottom < 2 * (s.above_ground + s.slack * z):  # its foot was cut off as ground
            return self._on_the_ground(found, float(row[_kernels.NEAREST]), rays)
        return found

    def _on_the_ground(self, found: Detection, depth: float, rays: Rays) -> Detection:
        """The box down to where the thing's axis meets the ground."""
        a, b, c = self.settings.ground
        axis = fuse(found, Distance(depth, Rule.CENTRE, *found.centre), rays).centre_site
        foot = np.array([axis[0], axis[1], a * axis[0] + b * axis[1] + c])
        low = min(max(found.bottom, rays.row_of(foot)), rays.camera.height - 0.5)
        return replace(found, bottom=low)
