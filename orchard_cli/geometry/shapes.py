"""The world's things as plain solids: upright cylinders, spheroids, capsules, turned boxes.

The renderer and the clearance measure the same solids, so that what is seen is what is hit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.world import Box, Person, Pole, Tree, Wire, World

WIRE_SEGMENTS = 16
"""Straight pieces of a hanging wire: they leave the parabola by less than sag / 256."""


@dataclass(frozen=True, slots=True, eq=False)
class Solids:
    """Solids of one kind of thing. Each row of an array is one solid, metres, site frame."""

    cylinders: Array  # (n, 5) x, y, z bottom, z top, radius; upright
    spheroids: Array  # (n, 5) x, y, z of the centre, horizontal radius, vertical radius
    capsules: Array  # (n, 7) end a x, y, z, end b x, y, z, radius
    boxes: Array  # (n, 7) centre x, y, z, half lengths x, y, z, yaw in rad


def tree_solids(trees: Sequence[Tree]) -> Solids:
    """A trunk up to the middle of its canopy and the canopy, one of each per tree."""
    middle = [tree.ground + tree.height - tree.canopy_height / 2 for tree in trees]
    return Solids(
        cylinders=_rows(
            [(t.x, t.y, t.ground, z, t.trunk_radius) for t, z in zip(trees, middle, strict=True)], 5
        ),
        spheroids=_rows(
            [
                (t.x, t.y, z, t.canopy_radius, t.canopy_height / 2)
                for t, z in zip(trees, middle, strict=True)
            ],
            5,
        ),
        capsules=np.empty((0, 7)),
        boxes=np.empty((0, 7)),
    )


def obstacle_solids(world: World) -> Solids:
    """Poles, wires (WIRE_SEGMENTS capsules each) and boxes: what stands still and is no tree."""
    return Solids(
        cylinders=_rows([_pole(pole) for pole in world.poles], 5),
        spheroids=np.empty((0, 5)),
        capsules=np.concatenate([wire_capsules(wire) for wire in world.wires])
        if world.wires
        else np.empty((0, 7)),
        boxes=_rows([_box(box) for box in world.boxes], 7),
    )


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


def person_capsules(people: Sequence[Person], time: float) -> Array:
    """The (n, 7) upright capsules of people at one time."""
    at = np.array([time])
    rows = []
    for person in people:
        x, y = walker_at(person, at)[0]
        top = max(person.height - person.radius, person.radius)
        rows.append((x, y, person.radius, x, y, top, person.radius))
    return _rows(rows, 7)


def _pole(pole: Pole) -> tuple[float, ...]:
    return (pole.x, pole.y, pole.ground, pole.ground + pole.height, pole.radius)


def _box(box: Box) -> tuple[float, ...]:
    return (*box.centre_site, *(np.asarray(box.size) / 2), box.yaw)


def _rows(rows: Sequence[tuple[float, ...]], width: int) -> Array:
    return np.array(rows, dtype=np.float64).reshape(len(rows), width)
