"""One case of a campaign: an orchard, how it shall be flown, and what really stands in it.

A case is a pure function of the campaign's seed and its own number, so that it can be flown again
alone, on any machine, whatever was flown before it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from orchard_cli.model.arrays import Array
from orchard_cli.model.mission import Limits
from orchard_cli.model.site import HeightReference, Orchard, SiteOrigin, TreeRow
from orchard_cli.model.tank import SPRAYER, Load
from orchard_cli.model.wishes import FlightWishes, Follow, HeightAbove
from orchard_cli.model.world import SensorNoise, Tree, Wind, World

from .things import Field, placed

CEP_OF_SIGMA = math.sqrt(2 * math.log(2))
"""Half of the fixes lie within this many standard deviations of one axis."""

MOST_WIND = 6.0  # m/s, mean
WORST_CEP = 1.5  # m
ENDURANCE = 2400.0  # s of hover with an empty tank
_ORIGIN = SiteOrigin(23.158, 113.352, 30.0, HeightReference.AMSL, math.radians(70.0))


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """What is flown, and where."""

    seed: int  # the campaign's
    number: int  # from 0
    orchard: Orchard  # what the crew surveyed
    wishes: FlightWishes
    world: World  # what stands there
    vehicle: str  # x500 or sprayer
    level: float  # of the tank at take-off
    cep: float  # m, of the estimated position

    @property
    def name(self) -> str:
        """Of its files."""
        return f"case-{self.seed}-{self.number}"


def make_case(seed: int, number: int) -> Case:
    """The case `number` of the campaign `seed`."""
    rng = np.random.default_rng([seed, number])
    walked = bool(rng.random() < 0.3)
    slope = np.zeros(2) if walked or rng.random() < 0.4 else rng.uniform(-0.08, 0.08, 2)
    rows = _rows(rng, slope)
    loaded = bool(rng.random() < 0.25)
    vehicle, level = (SPRAYER.name, float(rng.uniform(0.1, 1.0))) if loaded else ("x500", 1.0)
    wishes = _wishes(rng, vehicle, level)
    orchard = Orchard(f"case {number} of campaign {seed}", _ORIGIN, rows)
    trees = _trees(rng, rows)
    field = Field(rows, slope, _flown_height(rows, wishes), walked)
    cep = float(rng.uniform(0.1, WORST_CEP))
    world = World(
        name=orchard.name, trees=trees, wind=_wind(rng), noise=_noise(rng, cep),
        seed=int(rng.integers(2**31)),
    )  # fmt: skip
    return Case(seed, number, orchard, wishes, placed(rng, field, world), vehicle, level, cep)


def _rows(rng: np.random.Generator, slope: Array) -> tuple[TreeRow, ...]:
    """Two or three rows of 14 to 20 m with gaps, jitter and missing trees; the first is at 0."""
    spacing, apart = rng.uniform(2.5, 3.5), rng.uniform(4.5, 7.0)
    length = rng.uniform(14.0, 20.0)
    usual, rows = rng.uniform(2.0, 2.7), []
    for k in range(int(rng.integers(2, 4))):
        count = max(4, int(length / spacing) + 1)
        along = np.arange(count) * spacing + np.append(0.0, rng.normal(0, 0.15, count - 1))
        along += 0.0 if k == 0 else rng.uniform(-1.0, 1.0)
        across = k * apart + np.append(0.0, rng.normal(0, 0.08, count - 1))
        missing = rng.random(count) < 0.12
        missing[[0, -1]] = False  # a row's ends are where its trees are
        trunks = np.column_stack([along, across])[~missing]
        heights = usual + rng.uniform(-0.2, 0.2, len(trunks))
        rows.append(TreeRow(trunks, trunks @ slope, heights))
    return tuple(rows)


def _trees(rng: np.random.Generator, rows: tuple[TreeRow, ...]) -> tuple[Tree, ...]:
    """The surveyed trees, each with a canopy of its own; some have died since."""
    radius, trees = rng.uniform(0.9, 1.3), []
    for row in rows:
        for (x, y), ground, height in zip(row.trunks_site, row.ground, row.heights, strict=True):
            if rng.random() < 0.05:
                continue
            canopy = float(height - rng.uniform(0.4, 0.8))
            wide = float(radius + rng.uniform(-0.15, 0.15))
            trees.append(Tree(float(x), float(y), float(ground), float(height), wide, canopy))
    return tuple(trees)


def _wishes(rng: np.random.Generator, vehicle: str, level: float) -> FlightWishes:
    """Over the canopies with the clearance and a little more, at 0.8 to 1.4 m/s."""
    limits = Limits(speed=float(rng.uniform(0.8, 1.4)))
    if vehicle == SPRAYER.name:
        heavier = SPRAYER.mass_at(level) / SPRAYER.mass
        limits = Load(SPRAYER, level).limits(replace(limits, endurance=ENDURANCE / heavier**1.5))
    return FlightWishes(
        height=limits.clearance + float(rng.uniform(0.15, 0.6)),
        height_above=HeightAbove.CANOPY,
        corner_cut=1.0,
        limits=limits,
        follow=Follow.TERRAIN if rng.random() < 0.3 else Follow.LINE,
    )


def _flown_height(rows: tuple[TreeRow, ...], wishes: FlightWishes) -> float:
    """m above the ground at which the route is about flown."""
    return float(max(row.heights.max() for row in rows)) + wishes.height


def _wind(rng: np.random.Generator) -> Wind:
    speed, towards = rng.uniform(0.0, MOST_WIND), rng.uniform(-math.pi, math.pi)
    mean = np.array([speed * math.cos(towards), speed * math.sin(towards), 0.0])
    return Wind(mean, float(rng.uniform(0.05, 0.25) * speed), float(rng.uniform(1.0, 5.0)))


def _noise(rng: np.random.Generator, cep: float) -> SensorNoise:
    return SensorNoise(
        disparity_px=float(rng.uniform(0.05, 0.25)),
        dropout=float(rng.uniform(0.0, 0.2)),
        position=cep / CEP_OF_SIGMA,
        height=float(rng.uniform(0.03, 0.12)),
        velocity=float(rng.uniform(0.02, 0.05)),
        attitude=float(rng.uniform(0.002, 0.006)),
    )
