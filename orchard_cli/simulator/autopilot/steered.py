"""Modes that are steered from outside: offboard setpoints, and the pilot's sticks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.simulator.control import FREE, Demand

from .parameters import Parameters
from .seen import Seen
from .tasks import demand_of


@dataclass(frozen=True, slots=True, eq=False)
class Wanted:
    """An offboard setpoint; NaN where its type mask said to ignore."""

    time: float  # s since boot, of its arrival
    position_site: Vector  # (3,) m
    velocity_site: Vector  # (3,) m/s
    acceleration_site: Vector  # (3,) m/s²
    yaw_site: float  # rad
    yaw_rate: float  # rad/s

    def climbs(self, seen: Seen) -> bool:
        """Whether it asks to leave the ground (PX4: by position, else velocity, else thrust)."""
        for wanted, now in (
            (self.position_site[2], seen.position_site[2]),
            (self.velocity_site[2], 0.0),
            (self.acceleration_site[2], 0.0),
        ):
            if math.isfinite(wanted):
                return bool(wanted > now)
        return False

    def demand(self, values: Parameters) -> Demand:
        """Straight to the controller, as PX4 does: no smoothing, no limit on the yaw's rate."""
        return demand_of(
            self.position_site, self.velocity_site, self.acceleration_site,
            self.yaw_site, self.yaw_rate, values,
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Sticks:
    """The pilot's sticks, each -1 to 1 in body axes: forward, left, up, and turn left."""

    time: float
    forward: float
    left: float
    up: float
    turn: float


def position_mode(sticks: Sticks, hold: Vector, seen: Seen, values: Parameters) -> Demand:
    """PX4's position mode: sticks are velocities, a centred axis holds at `hold` (3,) m."""
    c, s = math.cos(seen.yaw_site), math.sin(seen.yaw_site)
    fast = values["MPC_VEL_MANUAL"]
    along, across = sticks.forward * fast, sticks.left * fast
    up = values["MPC_Z_VEL_MAX_UP"] if sticks.up > 0 else values["MPC_Z_VEL_MAX_DN"]
    position, velocity = np.array(hold), FREE.copy()
    if sticks.forward or sticks.left:
        position[:2] = math.nan
        velocity[:2] = along * c - across * s, along * s + across * c
    if sticks.up:
        position[2], velocity[2] = math.nan, sticks.up * up
    turn = sticks.turn * math.radians(values["MPC_MAN_Y_MAX"])
    return demand_of(position, velocity, FREE, seen.yaw_site if turn else math.nan, turn, values)
