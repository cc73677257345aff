"""Huang 2021, Table 6: past a wire pole, a tree, and both 9 m apart, at 1, 2 and 3 m/s and as many
metres of height (§2.6).

The paper gives neither the obstacles' sizes nor the distance that its planner keeps. Chosen here: a
pole of 0.3 m, a tree with a canopy of 2 m, and the distance that every mission keeps if nothing
else is said; flying 1 m above the ground, no mission may keep 1.6 m or 2.8 m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orchard_cli.commands.wiring import Choices

from .desk import Desk
from .flights import Task
from .posts import posts
from .rows import Row

if TYPE_CHECKING:
    from orchard_cli.analysis import Flight
    from orchard_cli.model.mission import Mission

AT = 30.0  # m along the row to the first obstacle
APART = 9.0  # m between pole and tree
LENGTH = 60.0  # m
CLEARANCE = 0.85  # m, airframe's centre to any surface
ACCELERATION = 2.0  # m/s²
WIND = 0.36  # m/s from the east, as on the paper's day; the flight goes west
OFFSETS = {1: 0.1, 3: 1.4}  # m, by m/s: the greatest of all scenarios (§3.4)
DISTANCES = {1: 2.8, 3: 1.6}  # m
POLE = "[[pole]]\nx_m = {x}\ny_m = 0.1\nradius_m = 0.15\nheight_m = 8.0\n"
TREE = (
    "[[tree]]\nx_m = {x}\ny_m = 0.1\nheight_m = 4.0\ncanopy_radius_m = 1.0\ncanopy_height_m = 3.6\n"
)
SCENES = {
    "wire pole": POLE.format(x=AT),
    "tree": TREE.format(x=AT),
    "both": POLE.format(x=AT) + TREE.format(x=AT + APART),
}


@dataclass(frozen=True, slots=True)
class _Case:
    scene: str
    pace: int  # m/s, and m above the ground: the paper's FPC 1 to 3

    @property
    def name(self) -> str:
        return f"{self.scene.replace(' ', '-')}-{self.pace}"


CASES = tuple(_Case(scene, pace) for scene in SCENES for pace in (1, 2, 3))


def table_6(desk: Desk) -> list[Row]:
    """Offset from what was planned, and the least distance, of nine flights."""
    made = [(case, _mission(case), _world(case, desk.seed)) for case in CASES]
    choices = Choices(system="astar-fused", seed=desk.seed, camera=(424, 240))
    tasks = [
        Task.of(desk.folder, case.name, mission, world, choices, desk.reuse)
        for case, mission, world in made
    ]
    desk.say(f"Table 6: {len(tasks)} flights")
    desk.fly_all(tasks)
    rows = []
    for case, mission, world in made:
        rows += _rows(case, desk.fly(case.name, mission, world, choices))
    return rows


def _rows(case: _Case, flight: Flight) -> list[Row]:
    row = f"{case.scene}, {case.pace} m/s, {case.pace} m"
    found = flight.metrics.figures["clearance_min_m"]
    near = float(found) if isinstance(found, int | float) else math.nan
    touched = flight.log.contacts or ()
    whole = isinstance(flight.metrics.figures["duration_s"], int | float)
    said = f"touched {touched[0]}" if touched else "whole" if whole else "not whole"
    note = f"{said}; the paper's is the greatest or least of its scenarios"
    return [
        Row(
            "Table 6", row, "trajectory offset", OFFSETS.get(case.pace), _offset(flight), "m", note
        ),
        Row("Table 6", row, "least distance", DISTANCES.get(case.pace), near, "m"),
    ]


def _offset(flight: Flight) -> float:
    """m, the greatest between where it truly was and the trajectory it flew, off the route."""
    import shapely

    truth, planned = flight.log.truth, flight.log.commands.positions_site
    assert truth is not None
    ways = [a for a in flight.log.planner if a.decision == "avoid"]
    if not ways or len(planned) < 2:
        return math.nan
    x, y = truth.positions_site[:, :2].T
    beside = (x > AT - 10.0) & (x < AT + APART + 10.0) & (truth.positions_site[:, 2] > 0.5)
    line = shapely.LineString(planned[np.isfinite(planned).all(axis=1), :2])
    away = shapely.distance(shapely.points(x[beside], y[beside]), line)
    return float(away.max(initial=0.0))


def _mission(case: _Case) -> Mission:
    from orchard_cli.mission import plan
    from orchard_cli.model.mission import Limits, Provenance
    from orchard_cli.model.site import HeightReference, Orchard, SiteOrigin, TreeRow
    from orchard_cli.model.wishes import FlightWishes

    row = TreeRow(np.array([[0.0, 0.0], [LENGTH, 0.0]]), np.zeros(2), np.full(2, 0.05))
    origin = SiteOrigin(32.1992, 119.5022, 10.0, HeightReference.AMSL, 1.5 * math.pi)
    limits = Limits(
        speed=float(case.pace), acceleration=ACCELERATION, acceleration_along=1.0,
        clearance=CLEARANCE,
    )  # fmt: skip
    wishes = FlightWishes(float(case.pace), swath=3.0, corner_cut=0.5, limits=limits)
    made = Provenance("Huang 2021", "0" * 64, "0", "2021-08-02T00:00:00Z")
    return plan(Orchard("Huang 2021", origin, (row,)), wishes, made)


def _world(case: _Case, seed: int) -> str:
    seen = posts(_mission(case), 0.4)
    wind = f"[wind]\nspeed_m_s = {WIND}\ntowards_deg = 0.0\n"
    return f'name = "{case.scene}"\nseed = {seed}\n{SCENES[case.scene]}{seen}{wind}'
