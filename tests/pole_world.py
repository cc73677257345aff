"""A stand-in for the map: upright poles that a perfect camera discovers, and a perfect flight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.mapping import Band, Window
from orchard_cli.model.depth import DepthFrame, d455
from orchard_cli.model.mission import Limits
from orchard_cli.model.sensors import Sensed, corner_lasers, plant_protection_radar
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import FlightMode, Landed, VehicleState
from orchard_cli.model.world import Pole, World
from orchard_cli.motion.situation import Avoid, Keep, Situation, Verdict
from orchard_cli.simulator.scene import Scene
from orchard_cli.simulator.sensors import RadarModel, RangeModel

CELL = 0.1
SIZE = 800
LOWER = -25.0  # m
BLANK = DepthFrame(0.0, np.zeros((120, 212), dtype=np.uint16), d455(212, 120))


class PoleMap:
    """Has the methods of OccupancyGrid that avoidance asks for; the poles have no end."""

    def __init__(self, poles, known=False):
        self.poles = np.asarray(poles, dtype=float).reshape(-1, 3)
        self.occupied = np.zeros((SIZE, SIZE), dtype=bool)
        self.observed = np.ones((SIZE, SIZE), dtype=bool)
        if known:
            for pole in self.poles:
                self._mark(self._rim(pole))

    def look(self, position, yaw, reach=5.7):
        """Mark what a level camera of 87 degrees sees of the poles, front sides only."""
        ahead = np.array([np.cos(yaw), np.sin(yaw)])
        for pole in self.poles:
            rim = self._rim(pole)
            rays = rim - position
            depth, side = rays @ ahead, rays @ np.array([-ahead[1], ahead[0]])
            seen = (depth > 0.6) & (depth < reach) & (np.abs(side) < depth * np.tan(0.7592))
            self._mark(rim[seen & (((rim - pole[:2]) * rays).sum(axis=1) < 0)])

    def band(self, centre_site, half_size, z_low, z_high):
        n = 2 * np.round(np.broadcast_to(half_size, 2) / CELL).astype(int)
        corner = np.round(np.asarray(centre_site)[:2] / CELL).astype(int) - n // 2
        i, j = corner - round(LOWER / CELL)
        square = slice(i, i + n[0]), slice(j, j + n[1])
        return Band(
            corner * CELL, CELL, self.occupied[square], self.observed[square], z_low, z_high
        )

    def window(self, lower_site, upper_site):
        corner = np.floor(np.asarray(lower_site) / CELL).astype(int)
        size = np.ceil(np.asarray(upper_site) / CELL).astype(int) - corner
        i, j = corner[:2] - round(LOWER / CELL)
        flat = self.occupied[i : i + size[0], j : j + size[1]]
        return Window(corner * CELL, CELL, np.repeat(flat[:, :, None], size[2], axis=2))

    def _rim(self, pole):
        angles = np.linspace(0, 2 * np.pi, 64, endpoint=False)
        return pole[:2] + pole[2] * np.column_stack([np.cos(angles), np.sin(angles)])

    def _mark(self, points):
        i, j = np.floor((points - LOWER) / CELL).astype(int).T
        self.occupied[i, j] = True


def straight_route(length=40.0, heading=0.0, speed=1.0, interval=0.5, height=3.5):
    """A straight line from rest to rest, 0.4 m/s² at its ends."""
    steps, v = [0.0, 0.0], 0.0
    while v < speed - 1e-9:
        v = min(speed, v + 0.4 * interval)
        steps.append(v * interval)
    cruise = int((length - 2 * sum(steps)) / (speed * interval))
    steps = steps + [speed * interval] * cruise + steps[::-1]
    along = np.concatenate([[0.0], np.cumsum(steps)])
    return Trajectory(
        0.0, interval,
        np.column_stack([along * np.cos(heading), along * np.sin(heading), 0 * along + height]),
    )  # fmt: skip


def situation(now, commit, active, reference, grid, limits=None, yaw=0.0, poles=None):
    here = active.at(now)
    nose = np.array([np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)])
    vehicle = VehicleState(
        now, here.position_site, here.velocity_site, nose, np.zeros(3),
        True, FlightMode.OFFBOARD, Landed.IN_AIR, now, 1.0, 16.0, True,
    )  # fmt: skip
    return Situation(
        now=now, commit=commit, vehicle=vehicle, active=active, reference=reference, grid=grid,
        frame=BLANK, limits=limits or Limits(), sensed=sensed(here, nose, now, poles),
    )  # fmt: skip


def sensed(here, nose, now, poles):
    """What a radar and four lasers see of poles (x, y, radius); None: there are no such sensors."""
    if poles is None:
        return Sensed()
    world = World("poles", poles=tuple(Pole(x, y, r, 8.0) for x, y, r in poles))
    scene, number = Scene(world), int(now * 100) + 1000
    radar = RadarModel(scene, plant_protection_radar(0.2))
    lasers = RangeModel(scene, corner_lasers(0.25))
    place, velocity = here.position_site, here.velocity_site
    return Sensed(
        radar.scan(place, velocity, nose, now, number), lasers.scan(place, nose, now, number)
    )


@dataclass
class Flight:
    positions: np.ndarray  # (n, 3)
    speeds: np.ndarray  # (n,)
    accelerations: np.ndarray  # (n,)
    verdicts: list[tuple[float, Verdict]]  # all but the plain keeps
    last: Trajectory

    def clearance(self, poles):
        return min(
            float((np.hypot(*(self.positions[:, :2] - p[:2]).T) - p[2]).min())
            for p in np.asarray(poles, dtype=float).reshape(-1, 3)
        )

    def kinds(self):
        return [type(v).__name__ for _, v in self.verdicts]


def fly(system, reference, grid, commit=0.2, rate=15.0, longest=90.0, each=None, limits=None):
    """Fly a reference with perfect tracking, one plan per frame. `each(now, grid)` may meddle."""
    active, now, yaw, held = reference, reference.start, 0.0, (-np.inf, None)
    rows, verdicts = [], []
    goal = reference.control_points_site[-1]
    while now < reference.start + longest:
        here = active.at(now)
        if now > active.end + 1.0 and np.allclose(here.position_site, goal):
            break
        ahead = active.at(now + 0.8).position_site - here.position_site
        if np.hypot(*ahead[:2]) > 0.05:
            yaw = np.arctan2(ahead[1], ahead[0])
        if now < held[0] and held[1] is not None:
            yaw = held[1]
        grid.look(here.position_site[:2], yaw)
        if each:
            each(now, grid)
        poles = grid.poles if system.needs else None
        verdict = system.plan(
            situation(now, now + commit, active, reference, grid, limits, yaw, poles)
        )
        if not isinstance(verdict, Keep):
            same_until(active, verdict.trajectory, now, now + commit)
            active = verdict.trajectory
            if isinstance(verdict, Avoid):
                held = (verdict.rejoin, verdict.yaw_site)
        if not (isinstance(verdict, Keep) and verdict.why == "free"):
            verdicts.append((now, verdict))
        rows.append(
            np.concatenate([here.position_site, here.velocity_site, here.acceleration_site])
        )
        now += 1.0 / rate
    log = np.array(rows)
    return Flight(
        log[:, :3], np.linalg.norm(log[:, 3:6], axis=1), np.linalg.norm(log[:, 6:], axis=1),
        verdicts, active,
    )  # fmt: skip


def same_until(old, new, begin, end):
    """What is flown up to `end` does not change: position, velocity, acceleration."""
    for time in np.linspace(begin, min(end, old.end), 5):
        a, b = old.at(time), new.at(time)
        np.testing.assert_allclose(a.position_site, b.position_site, atol=1e-9)
        np.testing.assert_allclose(a.velocity_site, b.velocity_site, atol=1e-9)


def avoids(flight):
    return [v for _, v in flight.verdicts if isinstance(v, Avoid)]
