"""The world's things as plain solids: upright cylinders, spheroids, capsules, turned boxes.

The renderer and the clearance measure the same solids, so that what is seen is what is hit.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.world import Box, Person, Pole, Tree, Wire, World

WIRE_SEGMENTS = 16
"""Straight pieces of a hanging wire: they leave the parabola by less than sag / 256."""

Thing = Tree | Pole | Wire | Box
"""What stands still."""


@dataclass(frozen=True, slots=True, eq=False)
class Solids:
    """Each row of an array is one solid, metres, site frame."""

    cylinders: Array = field(default_factory=lambda: np.empty((0, 5)))
    """(n, 5) x, y, z bottom, z top, radius; upright, flat ends"""
    spheroids: Array = field(default_factory=lambda: np.empty((0, 5)))
    """(n, 5) x, y, z of the centre, horizontal radius, vertical radius"""
    capsules: Array = field(default_factory=lambda: np.empty((0, 7)))
    """(n, 7) end a x, y, z, end b x, y, z, radius; round ends"""
    boxes: Array = field(default_factory=lambda: np.empty((0, 7)))
    """(n, 7) centre x, y, z, half lengths x, y, z, yaw in rad"""

    @classmethod
    def joined(cls, parts: Iterable[Solids]) -> Solids:
        """All solids of all parts, in order."""
        parts = [cls(), *parts]
        return cls(
            np.concatenate([part.cylinders for part in parts]),
            np.concatenate([part.spheroids for part in parts]),
            np.concatenate([part.capsules for part in parts]),
            np.concatenate([part.boxes for part in parts]),
        )

    def bounds(self) -> tuple[Points, Points]:
        """Lower and upper corners (n, 3) of all solids in the order of the fields."""
        pairs = [
            cylinder_bounds(self.cylinders), spheroid_bounds(self.spheroids),
            capsule_bounds(self.capsules), box_bounds(self.boxes),
        ]  # fmt: skip
        return np.concatenate([low for low, _ in pairs]), np.concatenate([top for _, top in pairs])


def solids_of(thing: Thing) -> Solids:
    """The solids of one thing that stands still.

    A tree is a trunk up to the middle of its canopy and the canopy; a wire is WIRE_SEGMENTS
    capsules.
    """
    match thing:
        case Tree():
            middle = thing.ground + thing.height - thing.canopy_height / 2
            return Solids(
                cylinders=np.array([[thing.x, thing.y, thing.ground, middle, thing.trunk_radius]]),
                spheroids=np.array(
                    [[thing.x, thing.y, middle, thing.canopy_radius, thing.canopy_height / 2]]
                ),
            )
        case Pole():
            top = thing.ground + thing.height
            return Solids(cylinders=np.array([[thing.x, thing.y, thing.ground, top, thing.radius]]))
        case Wire():
            return Solids(capsules=wire_capsules(thing))
        case Box():
            return Solids(
                boxes=np.concatenate([thing.centre_site, thing.size / 2, [thing.yaw]])[None]
            )


def tree_solids(world: World) -> Solids:
    """All trunks and canopies."""
    return Solids.joined(solids_of(tree) for tree in world.trees)


def obstacle_solids(world: World) -> Solids:
    """Poles, wires and boxes: what stands still and is no tree."""
    things: tuple[Thing, ...] = (*world.poles, *world.wires, *world.boxes)
    return Solids.joined(solids_of(thing) for thing in things)


def cylinder_bounds(rows: Array) -> tuple[Points, Points]:
    """(n, 5) -> lower and upper corners (n, 3)."""
    x, y, bottom, top, radius = rows.T
    return (
        np.column_stack([x - radius, y - radius, bottom]),
        np.column_stack([x + radius, y + radius, top]),
    )


def spheroid_bounds(rows: Array) -> tuple[Points, Points]:
    """(n, 5) -> lower and upper corners (n, 3)."""
    reach = rows[:, [3, 3, 4]]
    return rows[:, :3] - reach, rows[:, :3] + reach


def capsule_bounds(rows: Array) -> tuple[Points, Points]:
    """(n, 7) -> lower and upper corners (n, 3)."""
    a, b, radius = rows[:, :3], rows[:, 3:6], rows[:, 6:]
    return np.minimum(a, b) - radius, np.maximum(a, b) + radius


def box_bounds(rows: Array) -> tuple[Points, Points]:
    """(n, 7) -> lower and upper corners (n, 3)."""
    cos, sin = np.abs(np.cos(rows[:, 6])), np.abs(np.sin(rows[:, 6]))
    x, y, z = rows[:, 3:6].T
    reach = np.column_stack([cos * x + sin * y, sin * x + cos * y, z])
    return rows[:, :3] - reach, rows[:, :3] + reach


def wire_capsules(wire: Wire) -> Array:
    """The (WIRE_SEGMENTS, 7) capsules of a wire that hangs as a parabola below its chord."""
    share = np.linspace(0.0, 1.0, WIRE_SEGMENTS + 1)[:, None]
    points = wire.a_site + share * (wire.b_site - wire.a_site)
    points[:, 2] -= 4.0 * wire.sag * (share * (1.0 - share))[:, 0]
    radius = np.full((WIRE_SEGMENTS, 1), wire.radius)
    return np.hstack([points[:-1], points[1:], radius])


def walker_at(person: Person, times: Array) -> Points:
    """Where a person stands at times (n,): (n, 2) m. Walks a to b and back, over and over."""
    length = float(np.linalg.norm(person.b_site - person.a_site))
    if length == 0.0 or person.speed <= 0.0:
        return np.tile(person.a_site, (len(times), 1))
    walked = np.maximum(np.asarray(times) - person.start, 0.0) * person.speed / length
    share = 1.0 - np.abs(1.0 - np.mod(walked, 2.0))
    return person.a_site + share[:, None] * (person.b_site - person.a_site)


def person_capsule(person: Person, time: float) -> Array:
    """The (1, 7) upright capsule of a person at one time."""
    x, y = walker_at(person, np.array([time]))[0]
    top = max(person.height - person.radius, person.radius)
    return np.array([[x, y, person.radius, x, y, top, person.radius]])


def ground_plane(world: World) -> Array:
    """(a, b, c) of the ground z = a x + b y + c: level at 0 unless the trees stand higher or lower.

    A plane by least squares through the feet of the trees; what stands off it hangs or is buried
    by the difference.
    """
    feet = np.array([(tree.x, tree.y, tree.ground) for tree in world.trees]).reshape(-1, 3)
    if not feet[:, 2].any():
        return np.zeros(3)
    places = np.column_stack([feet[:, :2], np.ones(len(feet))])
    plane: Array = np.linalg.lstsq(places, feet[:, 2], rcond=None)[0]
    return plane
