"""What each automatic mode flies: one small object per mode, made anew on every entry.

Each is asked once per tick for the demand on the control cascade and tells what it is about:
`climbs` (wants to leave the ground), `lands` (is in its landing), `done`.
"""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.simulator.control import FREE, Demand

from .glide import Glide, Heading, stopping_point
from .parameters import Parameters
from .seen import Seen

FAR_BELOW = 100.0
"""m: a target that a landing never reaches, for where the ground is, is not known."""


class Task:
    """Glide to a target with the yaw kept; the other tasks steer the target."""

    lands = False
    done = False

    def __init__(self, seen: Seen, values: Parameters) -> None:
        self.glide = Glide(seen)
        self.heading = Heading(seen)
        self.target = stopping_point(seen, values["MPC_ACC_HOR"])
        self.yaw_wanted = seen.yaw_site
        self.speed = values["MPC_XY_CRUISE"]
        self.climb = values["MPC_Z_V_AUTO_UP"]
        self.descent = values["MPC_Z_V_AUTO_DN"]

    @property
    def climbs(self) -> bool:
        """Whether it asks to leave the ground."""
        return False

    @property
    def sinks(self) -> bool:
        """Whether it asks to go down now, as the land detector wants to know."""
        return bool(self.glide.velocity[2] < -0.2)

    def step(self, seen: Seen, values: Parameters, dt: float) -> Demand:
        """The demand for the tick that begins now."""
        self.steer(seen, values, dt)
        return self.demand(values)

    def steer(self, seen: Seen, values: Parameters, dt: float) -> None:
        """Move the glide on; it waits for a vehicle that falls behind by MPC_XY_ERR_MAX."""
        behind = math.dist(self.glide.position[:2], seen.position_site[:2])
        speed = self.speed if behind < values["MPC_XY_ERR_MAX"] else 0.0
        self.glide.towards(
            self.target, speed, self.climb, self.descent,
            values["MPC_ACC_HOR"], values["MPC_JERK_AUTO"], dt,
        )  # fmt: skip
        rate = math.radians(values["MPC_YAWRAUTO_MAX"])
        self.heading.towards(self.yaw_wanted, rate, math.radians(values["MPC_YAWRAUTO_ACC"]), dt)

    def demand(self, values: Parameters) -> Demand:
        """The glide as a demand within the limits of flight."""
        return demand_of(
            self.glide.position,
            self.glide.velocity,
            FREE,
            self.heading.yaw,
            self.heading.rate,
            values,
        )


def demand_of(
    position: Vector, velocity: Vector, acceleration: Vector, yaw: float, yaw_rate: float,
    values: Parameters,
) -> Demand:  # fmt: skip
    """A demand under the parameters' limits of flight."""
    return Demand(
        position, velocity, acceleration, yaw, yaw_rate,
        speed=values["MPC_XY_VEL_MAX"],
        climb=values["MPC_Z_VEL_MAX_UP"],
        descent=values["MPC_Z_VEL_MAX_DN"],
        tilt=math.radians(values["MPC_TILTMAX_AIR"]),
        collective_min=values["MPC_THR_MIN"],
    )  # fmt: skip


class Hold(Task):
    """Brake and stay."""

    @classmethod
    def after(cls, task: Task, seen: Seen, values: Parameters) -> Hold:
        """Stay at what `task` was heading for, as PX4 does at the end of a take-off."""
        hold = cls(seen, values)
        hold.glide, hold.heading, hold.target = task.glide, task.heading, task.target
        return hold


class TakeOff(Task):
    """Straight up to a height; done when it is nearly reached, as PX4 goes to hold then."""

    def __init__(self, seen: Seen, values: Parameters, height_site: float) -> None:
        super().__init__(seen, values)
        self.target = np.array([*seen.position_site[:2], height_site])
        self.climb = values["MPC_TKO_SPEED"]

    @property
    def climbs(self) -> bool:
        """Always."""
        return True

    def steer(self, seen: Seen, values: Parameters, dt: float) -> None:
        """Climb, and notice the height."""
        super().steer(seen, values, dt)
        self.done = bool(seen.position_site[2] > self.target[2] - values["NAV_MC_ALT_RAD"])


class Land(Task):
    """Straight down, slower near the ground."""

    lands = True

    def steer(self, seen: Seen, values: Parameters, dt: float) -> None:
        """Sink at the speed of the height, for as long as it takes."""
        self.descent = landing_speed(seen.height, values)
        self.target[2] = self.glide.position[2] - FAR_BELOW
        super().steer(seen, values, dt)

    def demand(self, values: Parameters) -> Demand:
        """Down by speed alone."""
        g, yaw = self.glide, self.heading
        position = g.position.copy()
        position[2] = math.nan
        return demand_of(position, g.velocity, g.acceleration, yaw.yaw, yaw.rate, values)


def landing_speed(height: float, values: Parameters) -> float:
    """PX4's descent speed at a height above the ground, m/s."""
    if height < values["MPC_LAND_ALT3"]:
        return values["MPC_LAND_CRWL"]
    low, high = values["MPC_LAND_ALT2"], values["MPC_LAND_ALT1"]
    share = min(1.0, max(0.0, (height - low) / (high - low)))
    return values["MPC_LAND_SPEED"] + share * (values["MPC_Z_V_AUTO_DN"] - values["MPC_LAND_SPEED"])
