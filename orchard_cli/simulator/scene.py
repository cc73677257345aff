"""The simulated world at work: what its camera sees, and what the airframe touches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from orchard_cli.geometry.clearance import Clearance, capsule_distances, clearance, nearest_solid
from orchard_cli.geometry.shapes import (
    Solids,
    Thing,
    ground_plane,
    obstacle_solids,
    person_capsule,
    solids_of,
    tree_solids,
)
from orchard_cli.model.arrays import Array, Vector
from orchard_cli.model.depth import DepthCamera
from orchard_cli.model.world import World

from .render import Painter, Shapes, colour_image, stereo_image
from .render.stereo import FARTHEST

T = TypeVar("T")


class Scene:
    """A world, ready to be looked at and flown into. Holds nothing that changes."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.ground = ground_plane(world)  # (a, b, c): z = a x + b y + c
        self._still = Solids.joined([tree_solids(world), obstacle_solids(world)])
        self._shapes = Shapes.of(self._still)
        self._layers = tuple(map(Shapes.of, _by_kind(world)))
        kinds: tuple[Sequence[Thing], ...] = (world.trees, world.poles, world.wires, world.boxes)
        self._things = tuple(
            (name, solids_of(thing)) for kind in kinds for name, thing in _numbered(kind)
        )
        bounds = [solids.bounds() for _, solids in self._things]
        low = np.array([low.min(axis=0) for low, _ in bounds]).reshape(-1, 3)
        high = np.array([high.max(axis=0) for _, high in bounds]).reshape(-1, 3)
        self._faces = np.hstack([low, -high])  # within: faces <= (point, -point)

    def nearness(
        self, camera: DepthCamera, position_site: Vector, site_from_body: Vector, time: float
    ) -> NDArray[np.float32]:
        """1 / true depth (h, w) along the optical axis of a camera on a body, 1/m; 0 for sky."""
        painter = Painter.at(camera, position_site, site_from_body, FARTHEST)
        return painter.paint(self.ground, self.shapes(time))

    def shapes(self, time: float) -> list[Shapes]:
        """Everything but the ground, ready to be drawn, with people where they walk then."""
        return [self._shapes, *map(Shapes.of, self._walkers(time))]

    def solids(self, time: float) -> Solids:
        """Everything but the ground, with people where they walk at that time."""
        if not self.world.people:
            return self._still
        return Solids.joined([self._still, *self._walkers(time)])

    def render(
        self,
        camera: DepthCamera,
        position_site: Vector,
        site_from_body: Vector,
        time: float,
        frame_number: int,
    ) -> NDArray[np.uint16]:
        """The camera's image (h, w) mm, with stereo's errors; the same for a seed and a number."""
        noise = self.world.noise
        return stereo_image(
            self.nearness(camera, position_site, site_from_body, time),
            camera, noise.disparity_px, noise.dropout, self.world.seed, frame_number,
        )  # fmt: skip

    def colours(
        self,
        camera: DepthCamera,
        position_site: Vector,
        site_from_body: Vector,
        time: float,
        frame_number: int,
    ) -> NDArray[np.uint8]:
        """Red, green and blue (h, w, 3), pixel by pixel what the depth camera sees."""
        painter = Painter.at(camera, position_site, site_from_body, FARTHEST)
        people = [Shapes.of(walker) for walker in self._walkers(time)]
        layers = [*((layer,) for layer in self._layers), people]
        return colour_image(painter, self.ground, layers, self.world.seed, frame_number)

    def ground_height(self, x: float, y: float) -> float:
        """z of the ground, m."""
        a, b, c = self.ground
        return float(a * x + b * y + c)

    def clearance(self, position_site: Vector, time: float) -> Clearance:
        """Distances from one point to the nearest obstacle and tree; arrays of one."""
        return clearance(self.world, np.asarray(position_site)[None], np.array([time]))

    def contact(self, position_site: Vector, radius: float, time: float) -> str | None:
        """What a ball touches, such as "pole 2" (counted from 1 as in the world), or None."""
        point = np.asarray(position_site, dtype=np.float64)
        for index in np.flatnonzero(self._apart(point) <= radius):
            name, solids = self._things[index]
            if nearest_solid(solids, point[None])[0] <= radius:
                return name
        for name, person in _numbered(self.world.people):
            if capsule_distances(point[None], person_capsule(person, time))[0, 0] <= radius:
                return name
        return None

    def room(self, position_site: Vector, radius: float) -> float:
        """m by which a ball can be moved along each axis and certainly touch nothing that stands
        still."""
        apart = self._apart(np.asarray(position_site, dtype=np.float64))
        return float(apart.min(initial=np.inf)) - radius

    def _apart(self, point: Vector) -> Array:
        """(n,) m along the axis where it is most, from the box around each still thing."""
        apart: Array = (self._faces - np.concatenate([point, -point])).max(axis=1)
        return apart

    def _walkers(self, time: float) -> list[Solids]:
        return [Solids(capsules=person_capsule(one, time)) for one in self.world.people]


def _numbered(things: Sequence[T]) -> list[tuple[str, T]]:
    return [(f"{type(t).__name__.lower()} {n}", t) for n, t in enumerate(things, start=1)]


def _by_kind(world: World) -> tuple[Solids, ...]:
    """Leaves, timber, metal and plaster, in the order of render/colour.py."""
    trees = tree_solids(world)
    kinds: tuple[Sequence[Thing], ...] = (world.poles, world.wires, world.boxes)
    poles, wires, boxes = (Solids.joined(map(solids_of, kind)) for kind in kinds)
    timber = Solids(cylinders=np.concatenate([trees.cylinders, poles.cylinders]))
    return Solids(spheroids=trees.spheroids), timber, wires, boxes
