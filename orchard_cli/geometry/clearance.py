"""How far points are from the surfaces of a world's things; negative inside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.world import World

from .shapes import Solids, obstacle_solids, person_capsule, tree_solids, walker_at

_ROOM = 1_000_000  # distances held at once: bounds the memory for long flights in large orchards


@dataclass(frozen=True, slots=True, eq=False)
class Clearance:
    """Signed distance to the nearest surface of a kind, m; infinite where there is none."""

    obstacles: Array  # (n,) poles, wires, boxes and people
    trees: Array  # (n,) trunks and canopies

    @property
    def nearest(self) -> Array:
        """(n,) m to whatever is nearest."""
        return np.minimum(self.obstacles, self.trees)


def clearance(world: World, points_site: Points, times: Array | None = None) -> Clearance:
    """Signed distance from points (n, 3) to the world's things, people where they are at `times`.

    `times` (n,) s on the flight clock; None: everybody where he starts. The ground is no thing.
    """
    points = np.atleast_2d(np.asarray(points_site, dtype=np.float64))
    obstacles = nearest_solid(obstacle_solids(world), points)
    when = np.full(len(points), -np.inf) if times is None else np.asarray(times, dtype=np.float64)
    for person in world.people:
        capsule = person_capsule(person, -np.inf)
        away = points.copy()
        away[:, :2] += capsule[0, :2] - walker_at(person, when)  # bring the walker to his start
        obstacles = np.minimum(obstacles, capsule_distances(away, capsule)[:, 0])
    return Clearance(obstacles, nearest_solid(tree_solids(world), points))


def nearest_solid(solids: Solids, points_site: Points) -> Array:
    """(n,) m, signed distance from points (n, 3) to the nearest of the solids; inf for none."""
    nearest = np.full(len(points_site), np.inf)
    for measure, rows in (
        (cylinder_distances, solids.cylinders),
        (spheroid_distances, solids.spheroids),
        (capsule_distances, solids.capsules),
        (box_distances, solids.boxes),
    ):
        if not len(rows):
            continue
        step = max(1, _ROOM // len(rows))
        for start in range(0, len(points_site), step):
            part = slice(start, start + step)
            here = measure(points_site[part], rows).min(axis=1)
            nearest[part] = np.minimum(nearest[part], here)
    return nearest


def cylinder_distances(points: Points, cylinders: Array) -> Array:
    """(n, 3), (k, 5) -> (n, k) m, to upright cylinders with flat ends."""
    x, y, bottom, top, radius = cylinders.T
    out = np.hypot(points[:, :1] - x, points[:, 1:2] - y) - radius
    over = np.abs(points[:, 2:3] - (bottom + top) / 2) - (top - bottom) / 2
    return _signed(np.stack([out, over], axis=2))


def capsule_distances(points: Points, capsules: Array) -> Array:
    """(n, 3), (k, 7) -> (n, k) m, to round-ended straight pieces."""
    start, along, radius = capsules[:, :3], capsules[:, 3:6] - capsules[:, :3], capsules[:, 6]
    length2 = np.maximum((along**2).sum(axis=1), 1e-12)
    offset = points[:, None] - start
    share = np.clip((offset * along).sum(axis=2) / length2, 0.0, 1.0)
    distances: Array = np.linalg.norm(offset - share[..., None] * along, axis=2) - radius
    return distances


def box_distances(points: Points, boxes: Array) -> Array:
    """(n, 3), (k, 7) -> (n, k) m, to boxes turned about their upright axis."""
    offset = points[:, None] - boxes[:, :3]
    cos, sin = np.cos(boxes[:, 6]), np.sin(boxes[:, 6])
    out = np.stack(
        [
            np.abs(cos * offset[..., 0] + sin * offset[..., 1]) - boxes[:, 3],
            np.abs(cos * offset[..., 1] - sin * offset[..., 0]) - boxes[:, 4],
            np.abs(offset[..., 2]) - boxes[:, 5],
        ],
        axis=2,
    )
    return _signed(out)


def spheroid_distances(points: Points, spheroids: Array) -> Array:
    """(n, 3), (k, 5) -> (n, k) m, exact for those that can be nearest, else a lower bound.

    A spheroid cannot be nearest when even the sphere inside another one is nearer than the
    sphere around it; the iteration is spared for those.
    """
    p = np.hypot(points[:, :1] - spheroids[:, 0], points[:, 1:2] - spheroids[:, 1])
    q = np.abs(points[:, 2:3] - spheroids[:, 2])
    centre = np.hypot(p, q)
    wide, tall = spheroids[:, 3], spheroids[:, 4]
    distances: Array = centre - np.maximum(wide, tall)
    near = distances <= (centre - np.minimum(wide, tall)).min(axis=1, keepdims=True)
    solid = np.nonzero(near)[1]
    distances[near] = _ellipse_distance(p[near], q[near], wide[solid], tall[solid])
    return distances


def _signed(out: Array) -> Array:
    """(n, k, m) distances beyond m pairs of faces at right angles -> (n, k) m to their solid."""
    distances: Array = np.minimum(out.max(axis=2), 0) + np.linalg.norm(np.maximum(out, 0), axis=2)
    return distances


def _ellipse_distance(p: Array, q: Array, a: Array, b: Array) -> Array:
    """Signed distance of (p, q), both >= 0, to the ellipse with semi-axes a and b; all (n,).

    Walks along the ellipse by the centre of curvature (A. Stephens, "Simple method for distance
    to ellipse", 2017): a few rounds reach a micrometre.
    """
    tx = np.full_like(p, np.sqrt(0.5))
    ty = tx.copy()
    for _ in range(10):
        ex, ey = (a * a - b * b) * tx**3 / a, (b * b - a * a) * ty**3 / b
        r = np.hypot(a * tx - ex, b * ty - ey)
        qx, qy = p - ex, q - ey
        away = np.maximum(np.hypot(qx, qy), 1e-12)
        next_tx = np.clip((qx * r / away + ex) / a, 0.0, 1.0)
        next_ty = np.clip((qy * r / away + ey) / b, 0.0, 1.0)
        norm = np.hypot(next_tx, next_ty)
        known = norm > 1e-9  # at the centre of a sphere every way is as near as the other
        tx = np.divide(next_tx, norm, out=tx, where=known)
        ty = np.divide(next_ty, norm, out=ty, where=known)
    inside = (p / a) ** 2 + (q / b) ** 2 < 1.0
    return np.where(inside, -1.0, 1.0) * np.hypot(p - a * tx, q - b * ty)
