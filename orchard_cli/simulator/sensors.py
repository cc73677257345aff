"""The simulated radar and laser rangefinders: the world's own geometry, then their errors."""

from __future__ import annotations

import numpy as np

from orchard_cli.geometry.rotations import matrix
from orchard_cli.geometry.shapes import person_capsule, walker_at
from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.depth import FORWARD, DepthCamera
from orchard_cli.model.sensors import Beams, Radar, RadarScan, RangeScan

from .render import Painter, cast
from .scene import Scene

RAY = np.radians(0.25)  # between two of the radar's rays across; twice that up and down
BIN_RANGE = 0.25  # m, and
BIN_AZIMUTH = np.radians(2.5)  # what lies in one such cell is one reflection
NEAREST = 0.2  # m: nearer than that a radar is blind
MOST = 64  # reflections of one scan, the nearest
RADAR_STREAM, RANGE_STREAM = 0x5AD, 0x1A5  # of random numbers, apart from all others


class RadarModel:
    """A radar that sees whole things as a few reflections, misses some and invents some.

    The ground gives no reflection of its own: at a grazing angle it is far below what stands
    upright. What it does give is in the clutter.
    """

    def __init__(self, scene: Scene, radar: Radar) -> None:
        self._scene = scene
        self.radar = radar
        columns, rows = round(radar.width / RAY), round(radar.height / (2 * RAY))
        self._camera = DepthCamera(
            width=columns,
            height=rows,
            fx=columns / 2 / np.tan(radar.width / 2),
            fy=rows / 2 / np.tan(radar.height / 2),
            cx=(columns - 1) / 2,
            cy=(rows - 1) / 2,
            range_min=NEAREST,
            range_max=radar.range_max,
            body_from_camera=radar.body_from_radar @ FORWARD,
            position_body=radar.position_body,
        )
        across = -(np.arange(columns) - self._camera.cx) / self._camera.fx
        up = -(np.arange(rows) - self._camera.cy)[:, None] / self._camera.fy
        self._longer = np.sqrt(1 + across**2 + up**2)  # (rows, columns) range per depth
        self._azimuths = np.broadcast_to(np.arctan(across), self._longer.shape)
        self._elevations = np.arctan2(up, np.sqrt(1 + across**2))

    def scan(
        self,
        position_site: Vector,
        velocity_site: Vector,
        site_from_body: Vector,
        time: float,
        number: int,
    ) -> RadarScan:
        """The `number`-th scan; the same for a seed and a number."""
        rng = np.random.default_rng([self._scene.world.seed, RADAR_STREAM, number])
        painter = Painter.at(self._camera, position_site, site_from_body, self.radar.range_max)
        nearness = painter.paint(np.array([0.0, 0.0, -1e9]), self._scene.shapes(time))
        ranges = self._longer / np.maximum(nearness, 1e-9)
        seen = (ranges > NEAREST) & (ranges < self.radar.range_max)
        hits = np.column_stack([ranges[seen], self._azimuths[seen], self._elevations[seen]])
        hits = _reflections(hits)
        site_from_radar = matrix(site_from_body) @ self.radar.body_from_radar
        ways_site = _directions(hits) @ site_from_radar.T
        points_site = painter.position_site + hits[:, :1] * ways_site
        moving = self._velocities(points_site, time) - velocity_site
        speeds = np.einsum("ij,ij->i", moving, ways_site)
        rows = self._erring(np.column_stack([hits, speeds]), rng)
        return RadarScan(time, rows, self.radar)

    def _velocities(self, points_site: Points, time: float) -> Points:
        """(n, 3) m/s of what reflects: nothing moves but people."""
        velocities = np.zeros_like(points_site)
        for person in self._scene.world.people:
            x, y, *_, radius = person_capsule(person, time)[0]
            before, after = walker_at(person, np.array([time, time + 0.01]))
            on = np.hypot(points_site[:, 0] - x, points_site[:, 1] - y) < radius + BIN_RANGE
            velocities[on, :2] = (after - before) / 0.01
        return velocities

    def _erring(self, rows: Array, rng: np.random.Generator) -> Array:
        noise = self._scene.world.noise
        rows = rows[rng.random(len(rows)) >= noise.radar_miss]
        sigmas = (noise.radar_range, noise.radar_angle, 2 * noise.radar_angle, noise.radar_speed)
        rows = rows + rng.standard_normal(rows.shape) * np.array(sigmas)
        ghosts = rng.uniform(-0.5, 0.5, (rng.poisson(noise.radar_clutter), 4))
        ghosts[:, 0] = NEAREST + (ghosts[:, 0] + 0.5) * (self.radar.range_max - NEAREST)
        ghosts[:, 1] *= self.radar.width
        ghosts[:, 2] *= self.radar.height
        ghosts[:, 3] *= 10.0  # m/s
        rows = np.concatenate([rows, ghosts])
        rows[:, 0] = np.clip(rows[:, 0], NEAREST, self.radar.range_max)
        found: Array = rows[np.argsort(rows[:, 0], kind="stable")][:MOST]
        return found


class RangeModel:
    """Laser rangefinders. They measure the ground too, when the body tilts them at it."""

    def __init__(self, scene: Scene, beams: Beams) -> None:
        self._scene = scene
        self.beams = beams

    def scan(
        self, position_site: Vector, site_from_body: Vector, time: float, number: int
    ) -> RangeScan:
        """The `number`-th measurement of all beams; the same for a seed and a number."""
        noise = self._scene.world.noise
        rng = np.random.default_rng([self._scene.world.seed, RANGE_STREAM, number])
        turn = matrix(site_from_body)
        ranges = cast(
            position_site + self.beams.places_body @ turn.T,
            self.beams.directions_body @ turn.T,
            self.beams.range_max,
            self._scene.ground,
            self._scene.solids(time),
        )
        ranges = np.maximum(ranges + noise.laser_range * rng.standard_normal(len(ranges)), 0.0)
        lost = rng.random(len(ranges)) < noise.dropout
        ranges[lost | (ranges > self.beams.range_max)] = np.inf
        return RangeScan(time, ranges, self.beams)


def _directions(hits: Array) -> Points:
    """Unit vectors (n, 3) in the radar's frame of (n, 3) range, azimuth, elevation."""
    flat = np.cos(hits[:, 2])
    along = [flat * np.cos(hits[:, 1]), flat * np.sin(hits[:, 1]), np.sin(hits[:, 2])]
    ways: Points = np.column_stack(along)
    return ways


def _reflections(hits: Array) -> Array:
    """Rays that hit (n, 3), gathered: the mean of each cell of range and azimuth."""
    if not len(hits):
        return hits
    cells = np.floor(hits[:, :2] / (BIN_RANGE, BIN_AZIMUTH)).astype(np.int64)
    _, owner = np.unique(cells, axis=0, return_inverse=True)
    owner = owner.reshape(-1)
    count = np.bincount(owner)
    return np.column_stack([np.bincount(owner, column) / count for column in hits.T])
