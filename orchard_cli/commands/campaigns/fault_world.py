"""The small orchard that faults are tried in: one row, one pole, half a minute of flight."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.campaign.faults import Fault
from orchard_cli.commands.wiring import Choices
from orchard_cli.mission import plan
from orchard_cli.model.mission import Limits, Mission, Provenance
from orchard_cli.model.site import HeightReference, Orchard, SiteOrigin, TreeRow
from orchard_cli.model.wishes import FlightWishes
from orchard_cli.model.world import Pole, Tree, World

POLE_X = 5.5  # m
TREES = 4
FENCE = 1.1  # m beside the route: no room round the pole
SEED = 7
EMPTY_AFTER = 4.0  # s of spraying
_ORIGIN = SiteOrigin(23.158, 113.352, 30.0, HeightReference.AMSL, math.radians(70.0))


def mission(fault: Fault) -> Mission:
    """9 m over four low trees at 1 m/s."""
    trunks = np.column_stack([np.arange(TREES) * 3.0, np.zeros(TREES)])
    row = TreeRow(trunks, np.zeros(TREES), np.full(TREES, 1.8))
    fence = np.empty((0, 2))
    if fault.name == "fence near":
        fence = np.array([(-8.0, -FENCE), (20.0, -FENCE), (20.0, FENCE), (-8.0, FENCE)])
    limits = Limits(endurance=900.0) if fault.name == "tank empty" else Limits()
    orchard = Orchard("fault row", _ORIGIN, (row,), fence_site=fence)
    made = Provenance("fault campaign", "0" * 64, "0", "2026-01-01T00:00:00Z")
    return plan(orchard, FlightWishes(3.2, limits=limits), made)


def world() -> World:
    """What stands there: the trees, and a pole on the line that nobody told of."""
    trees = tuple(Tree(3.0 * k, 0.0, height=1.8, canopy_height=1.2) for k in range(TREES))
    return World("fault row", trees=trees, poles=(Pole(POLE_X, 0.1, 0.15, 7.0),), seed=SEED)


def choices(fault: Fault, factor: float) -> Choices:
    """How it is flown."""
    speed = 1.0 if fault.real_time else factor
    if fault.name == "tank empty":
        level = EMPTY_AFTER * 2.0 / 60 / 32.0
        return Choices(speed_factor=speed, camera=(212, 120), vehicle="sprayer", level=level)
    return Choices(speed_factor=speed, camera=(212, 120))
