"""How far the simulated sprayer drifts after the command to stop: Ahmed 2022, §2.3, eqs. 27-28.

Flown as the `dfa` system flies: a velocity command becomes a trajectory that the vehicle is
committed to after COMMIT seconds, and the autopilot follows it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orchard_cli.avoidance.automaton import Drift, steered
from orchard_cli.flight.lookout import COMMIT
from orchard_cli.flight.runner import RATE
from orchard_cli.model.arrays import Array
from orchard_cli.model.site import HeightReference, SiteOrigin
from orchard_cli.model.tank import SPRAYER
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import Command, Setpoint
from orchard_cli.model.world import SensorNoise, World
from orchard_cli.simulator import LockstepSimulator, SimulatorSettings
from orchard_cli.simulator.fleet import kit

SPEEDS = (0.5, 0.75, 1.0, 1.1, 1.25)  # m/s, Table 3
LEVELS = (0.0, 0.5, 0.75, 0.9, 1.0)  # Table 3
FITTED = (0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0)  # levels that eq. 28 is fitted to
TRIED = (0.3, 0.5, 0.75, 1.0, 1.25)  # m/s, among which the avoidance velocity lies
HEIGHT = 3.0  # m
SETTLED = 4.0  # s of cruise before the stop, and of waiting after it
_QUIET = SensorNoise(position=0.0, height=0.0, velocity=0.0, attitude=0.0)
_ORIGIN = SiteOrigin(32.2, 119.5, 10.0, HeightReference.AMSL, 0.0)


@dataclass(frozen=True, slots=True)
class Test:
    """One stop."""

    level: float
    speed: float  # m/s
    drift: float  # m from where the command came to the farthest place


def fly_test(level: float, speed: float, acceleration: float) -> Test:
    """Take off, cruise at `speed`, stop. `acceleration` m/s² at most, less where the load asks."""
    most = min(acceleration, SPRAYER.acceleration_max(level))
    settings = SimulatorSettings(camera=None, kit=kit(SPRAYER.name, level))
    sim = LockstepSimulator(World("drift", noise=_QUIET), _ORIGIN, (0.0, 0.0), 0.0, settings)
    sim.clock.sleep_until(4.0)
    sim.vehicle.command(Command.ARM)
    sim.vehicle.command(Command.TAKEOFF, HEIGHT)
    sim.clock.sleep_until(16.0)
    here = np.array([0.0, 0.0, HEIGHT])
    active = Trajectory(15.0, 0.5, np.repeat(here[None], 5, axis=0))
    _follow(sim, active, sim.clock.now() + 0.5)
    sim.vehicle.command(Command.OFFBOARD)
    _follow(sim, active, sim.clock.now() + 1.5)
    along = np.array([speed, 0.0, 0.0])
    now = sim.clock.now()
    active = steered(active, (now, now + COMMIT), along, most, 60.0)
    began = _follow(sim, active, now + speed / most + SETTLED)[-1]
    now = sim.clock.now()
    active = steered(active, (now, now + COMMIT), np.zeros(3), most, 0.0)
    farthest = max(_follow(sim, active, now + speed / most + SETTLED))
    return Test(level, speed, float(farthest - began))


def _follow(sim: LockstepSimulator, active: Trajectory, until: float) -> list[float]:
    """Stream a trajectory; each x, m, where the vehicle truly was."""
    places: list[float] = []
    while sim.clock.now() < until:
        now = sim.clock.now()
        at = active.at(now)
        sim.vehicle.send(
            Setpoint(now, at.position_site, at.velocity_site, at.acceleration_site, 0.0)
        )
        sim.clock.sleep_until(now + 1 / RATE)
        places += [float(record.position_site[0]) for record in sim.truth.take()]
    return places


def identified(acceleration: float, distance: float) -> tuple[Drift, Array]:
    """The fit of eq. 28, and the (n, 2) levels and avoidance velocities that it goes through.

    Rule 2: at the avoidance velocity the drift is `distance` m.
    """
    speeds = [_speed_of(level, acceleration, distance) for level in FITTED]
    a, b, c, d = fit(FITTED, speeds)
    points = np.column_stack([FITTED, speeds])
    return Drift(a, b, c, d, distance, acceleration), points


def _speed_of(level: float, acceleration: float, distance: float) -> float:
    drifts = [fly_test(level, speed, acceleration).drift for speed in TRIED]
    return float(np.interp(distance, drifts, TRIED))


def fit(levels: Sequence[float], speeds: Sequence[float]) -> tuple[float, float, float, float]:
    """a, b, c, d of f(x) = a e^(b x) + c e^(d x) (eq. 28), by least squares."""
    from scipy.optimize import least_squares

    x, y = np.asarray(levels, dtype=np.float64), np.asarray(speeds, dtype=np.float64)

    def misses(p: Array) -> Array:
        return np.asarray(p[0] * np.exp(p[1] * x) + p[2] * np.exp(p[3] * x) - y)

    start = np.array([float(y[0]), 0.0, -0.01, 3.0])
    found = least_squares(misses, start, bounds=([-5, -20, -5, -20], [5, 20, 5, 20])).x
    a, b, c, d = (float(value) for value in found)
    return a, b, c, d
