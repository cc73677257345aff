"""What a surface in a depth image is, judged by its size and shape alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array, Vector
from orchard_cli.model.obstacles import Category


@dataclass(frozen=True, slots=True)
class ShapeRules:
    """Limits between the categories; metres unless said."""

    thin: float = 0.7  # a pole, or a person's shoulders, is not wider
    slender: float = 2.5  # times as high as wide: a pole
    wire: float = 0.12  # deviation across a wire, besides the camera's own errors
    wire_length: float = 1.0  # a wire is at least as long, and
    wire_above: float = 1.5  # hangs at least as high above the ground
    flat: float = 0.09  # deviation from a wall's plane, besides the camera's own errors
    wall: float = 1.0  # a wall is at least as wide
    upright: float = 0.5  # greatest upward part of a wall's normal
    afloat: float = 1.0  # a drone's lowest point is at least as high above the ground
    drone: float = 1.0  # a drone is not larger
    person: tuple[float, float] = (1.2, 2.1)  # heights of people
    shoulders: tuple[float, float] = (0.3, 0.9)  # widths of people
    sure: float = 0.2  # m of depth error above which no person or drone is told
    feet: float = 0.6  # a person's lowest visible point is not higher above the ground


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A surface as far as it is seen."""

    width: float  # m across the line of sight
    bottom: float  # m above the ground
    top: float  # m above the ground
    spreads: Vector  # (3,) m, deviations along its principal axes, greatest first
    axis_up: float  # 0 to 1, how upright the longest axis is
    normal_up: float  # 0 to 1, how upright the shortest axis is
    hidden: bool  # something nearer, or the image's edge, hides a part of it
    noise: float  # m, the camera's depth error at its distance

    @property
    def height(self) -> float:
        """m."""
        return self.top - self.bottom


def moments(sums: Vector, count: float) -> tuple[Vector, Array]:
    """Centre (3,) and covariance (3, 3) of `count` points with sums x, y, z, xx, xy, xz, yy, yz,
    zz."""
    centre = sums[:3] / count
    xx, xy, xz, yy, yz, zz = sums[3:9] / count
    second = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return centre, second - np.outer(centre, centre)


def principal(covariance: Array) -> tuple[Vector, Array]:
    """Deviations (3,) greatest first, and their axes (3, 3) as columns."""
    values, axes = np.linalg.eigh(covariance)
    return np.sqrt(np.maximum(values[::-1], 0.0)), axes[:, ::-1]


def breadth(centre: Vector, covariance: Array) -> float:
    """m across the line of sight, level, of points that fill it evenly: as a box's width, but for
    an image that rolls."""
    across = np.array([-centre[1], centre[0], 0.0])
    across /= max(float(np.linalg.norm(across)), 1e-9)
    return float(np.sqrt(12.0 * max(across @ covariance @ across, 0.0)))


def judge(shape: Shape, rules: ShapeRules) -> Category:
    """The category, thin things first; what is nothing else is a tree: a round bulk.

    A person is told by size alone, and only when all of it is seen: a young tree of a person's size
    is taken for one, which is the safe error. A still person is no different from a walking one.
    """
    across = rules.wire + shape.noise
    long = 3.5 * shape.spreads[0]  # length of an even line with that deviation
    if (
        shape.spreads[1] < across
        and long > rules.wire_length
        and shape.axis_up < 0.7
        and shape.bottom > rules.wire_above
    ):
        return Category.WIRE
    if shape.width < rules.thin and shape.height > rules.slender * shape.width:
        whole = not shape.hidden and shape.bottom < rules.feet and shape.noise < rules.sure
        low, high = rules.person
        if whole and low < shape.top < high and shape.width > rules.shoulders[0]:
            return Category.PERSON
        return Category.POLE
    if not shape.hidden and shape.noise < rules.sure:
        low, high = rules.person
        narrow, broad = rules.shoulders
        if (
            low < shape.top < high
            and narrow < shape.width < broad
            and shape.bottom < rules.feet
            and shape.height > 1.3 * shape.width
        ):
            return Category.PERSON
        if shape.bottom > rules.afloat and max(shape.width, shape.height) < rules.drone:
            return Category.DRONE
    wall = shape.spreads[2] < rules.flat + shape.noise and shape.normal_up < rules.upright
    return Category.BUILDING if wall and shape.width > rules.wall else Category.TREE
