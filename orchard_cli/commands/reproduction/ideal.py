"""Flights with perfect tracking past upright poles that a perfect camera discovers.

As EGO-Planner's own program was measured: no noise, no delay but the commit time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orchard_cli.commands.benchmarks.frames import in_flight
from orchard_cli.flight.lookout import COMMIT
from orchard_cli.flight.ports import Avoidance
from orchard_cli.mapping import OccupancyGrid, Window
from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.depth import DepthFrame, d455
from orchard_cli.model.mission import Limits
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import Pose
from orchard_cli.model.world import Pole
from orchard_cli.motion.situation import Keep, Situation
from orchard_cli.motion.yaw import heading_ahead

RATE = 15.0  # Hz
REACH = 4.2  # m at which a new pole is in EGO-Planner's map: 4.5 m, and six frames
HALF_VIEW = math.radians(40.0)  # of its camera, 640 px at 387 px focal length
_CELL = 0.1  # m
_RIM = 64  # points of a pole's surface
_BLANK = DepthFrame(0.0, np.zeros((120, 212), dtype=np.uint16), d455(212, 120))


class SeenPoles(OccupancyGrid):
    """A map of poles without end; their front sides are in it once they have been seen."""

    def __init__(self, poles: Sequence[Pole]) -> None:
        super().__init__()
        angles = np.linspace(0, 2 * np.pi, _RIM, endpoint=False)
        ways = np.column_stack([np.cos(angles), np.sin(angles)])
        self._rims = np.array([[p.x, p.y] + p.radius * ways for p in poles])  # (n, _RIM, 2)
        self._outwards = ways
        self._columns: set[tuple[int, int]] = set()

    def see(self, position_site: Vector, yaw: float) -> None:
        """Add what of the poles is in view."""
        rays = self._rims - position_site[:2]
        far = np.hypot(rays[..., 0], rays[..., 1])
        aside = np.abs(np.angle(np.exp(1j * (np.arctan2(rays[..., 1], rays[..., 0]) - yaw))))
        front = (rays * self._outwards).sum(axis=2) < 0
        seen = self._rims[(far < REACH) & (aside < HALF_VIEW) & front]
        self._columns.update((int(i), int(j)) for i, j in np.floor(seen / _CELL))

    def window(self, lower_site: Vector, upper_site: Vector) -> Window:
        """As the grid that it stands for."""
        corner = np.floor(np.asarray(lower_site) / _CELL).astype(int)
        size = np.ceil(np.asarray(upper_site) / _CELL).astype(int) - corner
        occupied = np.zeros(tuple(size), dtype=np.bool_)
        for i, j in self._columns:
            a, b = i - corner[0], j - corner[1]
            if 0 <= a < size[0] and 0 <= b < size[1]:
                occupied[a, b] = True
        return Window(corner * _CELL, _CELL, occupied)


@dataclass(frozen=True, slots=True, eq=False)
class Flown:
    """One such flight."""

    times: Array  # (n,) s
    places: Points  # (n, 3) m
    curves: int  # new trajectories

    def clearance(self, poles: Sequence[Pole]) -> float:
        """Least distance of the vehicle's centre to a pole's surface, m."""
        return min(
            float(np.hypot(self.places[:, 0] - p.x, self.places[:, 1] - p.y).min()) - p.radius
            for p in poles
        )


def fly(system: Avoidance, reference: Trajectory, poles: Sequence[Pole], limits: Limits) -> Flown:
    """Fly a reference to its end, one call per frame."""
    grid, active, yaw, curves = SeenPoles(poles), reference, 0.0, 0
    now, rows = reference.start, []
    longest = reference.start + 3 * (reference.end - reference.start)
    while now < min(active.end, longest):
        here = active.at(now)
        yaw = heading_ahead(active, now, 1.0) or yaw
        grid.see(here.position_site, yaw)
        attitude = np.array([math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)])
        vehicle = in_flight(Pose(now, here.position_site, attitude), here.velocity_site)
        verdict = system.plan(
            Situation(now, now + COMMIT, vehicle, active, reference, grid, _BLANK, limits)
        )
        if not isinstance(verdict, Keep):
            active, curves = verdict.trajectory, curves + 1
        rows.append(np.append(now, here.position_site))
        now += 1.0 / RATE
    track = np.array([*rows, [now, *active.at(now).position_site]])
    return Flown(track[:, 0], track[:, 1:], curves)
