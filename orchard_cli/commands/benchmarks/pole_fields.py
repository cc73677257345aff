"""Random fields of poles for one replan each, as EGO-Planner was measured in.

Everything is drawn from the seed; the map knows every pole, whole.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from orchard_cli.flight.lookout import COMMIT
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.model.arrays import Points
from orchard_cli.model.depth import DepthFrame, d455
from orchard_cli.model.mission import Limits
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import Pose
from orchard_cli.motion.situation import Situation
from orchard_cli.motion.timing import PathLimits, time_path

from .frames import in_flight

RADIUS = 0.15  # m, of a pole
TARGET = 7.0  # m ahead
HEIGHT = 3.5  # m
ROUTE = 30.0  # m of straight route from rest
HALF = 12.0  # m: poles stand up to here from the vehicle; a little less than the map holds
FREE_START = 2.0  # m around the vehicle: nearer ones would have been seen and avoided before
FREE_TARGET = 1.2  # m around the target to a pole's surface: the airframe can stand there
AHEAD = (2.0, 4.5)  # m, where a pole is forced
BESIDE = 0.2  # m, how far beside the line it may be


@dataclass(frozen=True, slots=True)
class Field:
    """A kind of pole field."""

    name: str
    density: float  # poles per m²
    forced: bool  # a pole stands in the way
    free_target: float = FREE_TARGET  # m around the target to a pole's surface


FIELDS = (
    Field("density_0.02", 0.02, False),
    Field("density_0.05", 0.05, False),
    Field("forced", 0.0, True),
    Field("forced_0.02", 0.02, True),
    Field("forced_0.05", 0.05, True),
)


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """One call: what the system is told, and where the poles really are."""

    situation: Situation
    poles: Points  # (n, 2) m, their axes
    target_time: float  # s, when the reference is at the target
    forced_at: float | None  # m to the axis of the pole that was put in the way


class KnownGrid(OccupancyGrid):
    """A map around (0, 0, HEIGHT) that knows a pole field exactly, without having looked."""

    def __init__(self) -> None:
        super().__init__()
        self._follow(np.array([0.0, 0.0, HEIGHT]))

    def know(self, poles: Points) -> None:
        """Free everywhere but in the cells that a pole (n, 2) touches, at all heights."""
        self._log_odds[:] = self._free
        cell, reach = self.settings.cell, int(RADIUS / self.settings.cell) + 1
        steps = np.arange(-reach, reach + 1)
        around = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
        for pole in poles:
            cells = np.floor(pole / cell).astype(np.int64) + around
            nearest = np.clip(pole, cells * cell, (cells + 1) * cell)
            touched = cells[np.hypot(*(nearest - pole).T) <= RADIUS]
            place = touched & (self._size[:2] - 1)
            self._log_odds[place[:, 0], place[:, 1]] = self._certain


def cases(field: Field, count: int, seed: int) -> Iterator[Case]:
    """`count` cases of a kind; the same for a seed. One map is used again for all of them."""
    limits, grid = Limits(), KnownGrid()
    base = straight_route(limits)
    random = np.random.default_rng([seed, round(1000 * field.density), field.forced])
    for _ in range(count):
        heading, speed = random.uniform(-math.pi, math.pi), random.uniform(0.0, limits.speed)
        now = time_of_speed(base, speed)
        route = turned(base, heading, float(base.at(now).position_site[0]))
        nose = np.array([math.cos(heading), math.sin(heading)])
        poles = _poles(field, nose, random)
        grid.know(poles)
        state = route.at(now)
        attitude = np.array([math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)])
        vehicle = in_flight(Pose(now, state.position_site, attitude), state.velocity_site)
        frame = DepthFrame(now, np.zeros((120, 212), dtype=np.uint16), d455(212, 120))
        yield Case(
            Situation(now, now + COMMIT, vehicle, route, route, grid, frame, limits),
            poles,
            time_of_length(route, now, TARGET),
            float(np.hypot(*poles[0])) if field.forced else None,
        )


def _poles(field: Field, nose: Points, random: np.random.Generator) -> Points:
    """Poles (n, 2) around a vehicle in the origin, none too near to it or to its target."""
    poles = random.uniform(-HALF, HALF, (random.poisson(field.density * (2 * HALF) ** 2), 2))
    if field.forced:
        side = np.array([-nose[1], nose[0]])
        forced = random.uniform(*AHEAD) * nose + random.uniform(-BESIDE, BESIDE) * side
        poles = np.vstack([forced, poles])
    clear = np.hypot(*poles.T) >= FREE_START
    clear &= np.hypot(*(poles - TARGET * nose).T) >= field.free_target + RADIUS
    if field.forced:
        clear[0] = True
    return np.asarray(poles[clear])


def straight_route(limits: Limits) -> Trajectory:
    """From rest along +x at HEIGHT, in the mission's own time law."""
    ends = np.array([[0.0, 0.0, HEIGHT], [ROUTE, 0.0, HEIGHT]])
    law = PathLimits(
        limits.speed, limits.acceleration, limits.acceleration_along,
        limits.yaw_rate, limits.climb_speed,
    )  # fmt: skip
    return time_path(ends, law).trajectory


def time_of_speed(route: Trajectory, speed: float) -> float:
    """When a route from rest first has a speed, s."""
    times = np.linspace(route.start, (route.start + route.end) / 2, 2000)
    speeds = np.linalg.norm(route.sample(times)[1], axis=1)
    reached = np.flatnonzero(speeds >= min(speed, float(speeds.max())))
    return float(times[reached[0]])


def time_of_length(route: Trajectory, begin: float, length: float) -> float:
    """When a straight route has come `length` m farther than at `begin`, s."""
    times = np.linspace(begin, route.end, 2000)
    places = route.sample(times)[0]
    gone = np.linalg.norm(places - places[0], axis=1)
    return float(times[min(int(np.searchsorted(gone, length)), len(times) - 1)])


def turned(base: Trajectory, heading: float, gone: float) -> Trajectory:
    """A route along +x, so that its point `gone` m from the start is the origin, and turned."""
    along = base.control_points_site[:, 0] - gone
    points = np.stack(
        [along * math.cos(heading), along * math.sin(heading), base.control_points_site[:, 2]],
        axis=1,
    )
    return Trajectory(base.start, base.interval, points)
