"""Boxes and depth become obstacles with size and place (Wang 2020, eqs. 1-2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.depth import DepthCamera
from orchard_cli.model.obstacles import Category, Detection, Obstacle

from .distance import Distance
from .rays import Rays

EDGE = 1.5  # px: a box that ends so near to the image's edge is cut by it
FLAT = (Category.BUILDING, Category.WIRE)  # what has no round cross-section
ROUNDEST = math.radians(80.0)  # half of the angle that a round thing may fill


@dataclass(frozen=True, slots=True)
class Extent:
    """Size of a thing in its camera's frame: x right, y down, z along the optical axis."""

    width: float  # m
    height: float  # m
    centre: tuple[float, float]  # m: x and z of its upright axis
    depth: float  # m: z at which its height was read


def flat_extent(detection: Detection, depth: float, camera: DepthCamera) -> Extent:
    """As published: eq. 1 for the box's corners at the surface's depth, eq. 2 for the size."""
    left, right = (depth * (u - camera.cx) / camera.fx for u in (detection.left, detection.right))
    height = depth * (detection.bottom - detection.top) / camera.fy
    return Extent(right - left, height, ((left + right) / 2, depth), depth)


def round_extent(detection: Detection, depth: float, camera: DepthCamera) -> Extent:
    """The same for a thing with a round cross-section (Wang 2020, §3.6, hypothesis ii).

    Its outline is not where its nearest point is: the box's sides are tangents. With the range ρ
    of the nearest point and half the angle θ between the tangents, its radius is
    ρ sin θ / (1 - sin θ). Its top and bottom are taken to be at its axis.
    """
    sides = [math.atan((u - camera.cx) / camera.fx) for u in (detection.left, detection.right)]
    middle, half = sum(sides) / 2, min((sides[1] - sides[0]) / 2, ROUNDEST)
    reach = depth / math.cos(middle)
    radius = reach * math.sin(half) / (1 - math.sin(half))
    axis = reach + radius
    z = axis * math.cos(middle)
    height = z * (detection.bottom - detection.top) / camera.fy
    return Extent(2 * radius, height, (axis * math.sin(middle), z), z)


def fuse(detection: Detection, distance: Distance, rays: Rays) -> Obstacle:
    """Size and place of a detection at a distance, whatever the vehicle's attitude."""
    camera = rays.camera
    measure = flat_extent if detection.category in FLAT else round_extent
    extent = measure(detection, distance.depth, camera)
    u, v = detection.centre
    x, z = extent.centre
    across = rays.site_from_camera @ np.array([x, (v - camera.cy) / camera.fy * z, z])
    top, bottom = (
        float(rays.position_site[2] + extent.depth * rays.at(u, edge)[2])
        for edge in (detection.top, detection.bottom)
    )
    place = rays.position_site + across
    low, high = sorted((bottom, top))
    return Obstacle(
        detection,
        distance.depth,
        extent.width,
        np.array([place[0], place[1], (low + high) / 2]),
        low,
        high,
        cut=(detection.left < EDGE - 0.5 or detection.right > camera.width - 0.5 - EDGE),
    )
