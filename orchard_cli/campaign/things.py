"""What the survey does not know: poles, sheds, wires, people, and trees that have shot up.

Near the route, on it, or closing it; never where the vehicle takes off or lands, which the crew
sees. Wires are known to nobody, as everywhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from orchard_cli.model.arrays import Array
from orchard_cli.model.site import TreeRow
from orchard_cli.model.world import Box, Person, Pole, Tree, Wire, World

KINDS = ("pole", "box", "tall tree", "wire")
SHARES = (0.6, 0.15, 0.18, 0.07)
ASIDE = 0.9  # m, standard deviation of how far beside a row's line something stands
HEADLAND_SHARE = 0.15  # of the poles: they stand where the vehicle turns


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """Where things may be put."""

    rows: tuple[TreeRow, ...]
    slope: Array  # (2,) m of ground per m along x and y
    flown: float  # m above the ground at which the route is about flown
    walked: bool  # whether somebody is about

    def ground(self, x: float, y: float) -> float:
        """z of the ground, m."""
        return float(np.array([x, y]) @ self.slope)

    def beside_a_row(self, rng: np.random.Generator, aside: float) -> tuple[float, float]:
        """A place along a row, `aside` m (standard deviation) beside its line."""
        ends = self.rows[int(rng.integers(len(self.rows)))].trunks_site[[0, -1]]
        x, y = ends[0] + rng.uniform(0.1, 1.0) * (ends[1] - ends[0])
        return float(x), float(y + rng.normal(0.0, aside))

    def between_rows(self, rng: np.random.Generator) -> tuple[float, float]:
        """A place on the headland where the first turn is."""
        a, b = (row.trunks_site[-1] for row in self.rows[:2])
        x, y = a + rng.uniform(0.3, 0.7) * (b - a)
        return float(x + rng.uniform(-0.5, 1.0)), float(y)


def placed(rng: np.random.Generator, field: Field, world: World) -> World:
    """The world with one to three things that nobody told of."""
    for kind in rng.choice(KINDS, int(rng.integers(1, 4)), p=SHARES):
        world = _PUT[str(kind)](rng, field, world)
    return replace(world, people=(_person(rng, field),)) if field.walked else world


def _pole(rng: np.random.Generator, field: Field, world: World) -> World:
    on_turn = rng.random() < HEADLAND_SHARE
    x, y = field.between_rows(rng) if on_turn else field.beside_a_row(rng, ASIDE)
    height = field.flown + float(rng.uniform(0.5, 4.0))
    pole = Pole(x, y, float(rng.uniform(0.04, 0.25)), height, field.ground(x, y))
    return replace(world, poles=(*world.poles, pole))


def _box(rng: np.random.Generator, field: Field, world: World) -> World:
    """A shed, a tank on legs' height, a tractor: as high as the route, or lower."""
    x, y = field.beside_a_row(rng, 2 * ASIDE)
    size = np.array([*rng.uniform(0.5, 2.5, 2), field.flown * rng.uniform(0.6, 1.4)])
    centre = np.array([x, y, field.ground(x, y) + size[2] / 2])
    box = Box(centre, size, float(rng.uniform(0.0, math.pi)))
    return replace(world, boxes=(*world.boxes, box))


def _tall_tree(rng: np.random.Generator, field: Field, world: World) -> World:
    """A tree in a row that reaches into the route, or over it."""
    x, y = field.beside_a_row(rng, 0.2)
    height = field.flown + float(rng.uniform(-0.3, 1.5))
    tree = Tree(x, y, field.ground(x, y), height, float(rng.uniform(0.6, 1.3)), height - 0.6)
    return replace(world, trees=(*world.trees, tree))


def _wire(rng: np.random.Generator, field: Field, world: World) -> World:
    """Across all rows between two posts: at the route's height or over it."""
    first, last = field.rows[0].trunks_site, field.rows[-1].trunks_site
    x = float(rng.uniform(first[:, 0].min() + 4.0, first[:, 0].max()))
    ends = []
    for y in (float(first[:, 1].min()) - 4.0, float(last[:, 1].max()) + 4.0):
        ends.append((x, y, field.ground(x, y)))
    up = field.flown + float(rng.uniform(-0.4, 1.6))
    a, b = (np.array([x, y, ground + up]) for x, y, ground in ends)
    wire = Wire(a, b, float(rng.uniform(0.0, 0.3)), float(rng.uniform(0.004, 0.012)))
    posts = tuple(Pole(x, y, 0.1, up + 0.2, ground) for x, y, ground in ends)
    return replace(world, wires=(*world.wires, wire), poles=(*world.poles, *posts))


def _person(rng: np.random.Generator, field: Field) -> Person:
    """Walks across the rows or along one; one in three stands on a ladder at a tree."""
    x, y = field.beside_a_row(rng, ASIDE)
    if rng.random() < 1 / 3:
        here = np.array([x, y])
        return Person(here, here, 0.0, height=float(rng.uniform(2.5, 3.0)))
    low = float(field.rows[0].trunks_site[:, 1].min()) - 2.0
    high = float(field.rows[-1].trunks_site[:, 1].max()) + 2.0
    across = rng.random() < 0.5
    far = float(rng.uniform(2.0, field.rows[0].trunks_site[-1, 0]))
    a, b = ((x, low), (x, high)) if across else ((x, y), (far, y))
    speed, start = float(rng.uniform(0.5, 1.5)), float(rng.uniform(0.0, 40.0))
    height = float(rng.uniform(1.55, 1.9))
    return Person(np.array(a), np.array(b), speed, height=height, start=start)


_PUT = {"pole": _pole, "box": _box, "tall tree": _tall_tree, "wire": _wire}
