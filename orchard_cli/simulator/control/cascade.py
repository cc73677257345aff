"""The control cascade as one object: gains, memory, and the flight of a tick."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Protocol

import numpy as np

from orchard_cli.model.arrays import Array, Vector
from orchard_cli.simulator.body import Body

from ._kernels import FLYING, IDLE, OFF, fly

FREE = np.full(3, math.nan)
"""Not controlled."""
FREE.setflags(write=False)

STEP = 0.002  # s, rotors, attitude and rate loops; PX4 runs its rate loop at 400 Hz and more


class Motors(IntEnum):
    """What the rotors are allowed to do."""

    OFF = OFF
    IDLE = IDLE
    FLYING = FLYING


@dataclass(frozen=True, slots=True, eq=False)
class Demand:
    """What the position controller is asked for in a tick; NaN means not controlled.

    Position with velocity makes the velocity a feed-forward (PX4's trajectory setpoint).
    """

    position_site: Vector  # (3,) m
    velocity_site: Vector  # (3,) m/s
    acceleration_site: Vector  # (3,) m/s²
    yaw_site: float  # rad
    yaw_rate: float  # rad/s
    speed: float  # m/s, greatest horizontal
    climb: float  # m/s, greatest upwards; below zero during the take-off ramp
    descent: float  # m/s, greatest downwards
    tilt: float  # rad, greatest
    collective_min: float  # share of the greatest thrust

    def ramped(self, climb: float, tilt: float) -> Demand:
        """The same during the take-off ramp: climb and tilt limited, thrust from nothing."""
        return replace(self, climb=climb, tilt=tilt, collective_min=0.0)

    def pressed(self, collective: float) -> Demand:
        """The same with another least thrust."""
        return replace(self, collective_min=collective)


class Values(Protocol):
    """Where gains are read from: parameter name → value."""

    def __getitem__(self, name: str) -> float:
        """Value of a parameter."""
        ...


def gains(values: Values | Mapping[str, float]) -> Array:
    """(34,) PX4's MPC_* and MC_* parameters as the kernels take them."""

    def triple(xy: str, z: str) -> list[float]:
        return [values[xy], values[xy], values[z]]

    def axes(form: str) -> list[float]:
        return [values[form.format(axis)] for axis in ("ROLL", "PITCH", "YAW")]

    return np.array(
        triple("MPC_XY_P", "MPC_Z_P")
        + triple("MPC_XY_VEL_P_ACC", "MPC_Z_VEL_P_ACC")
        + triple("MPC_XY_VEL_I_ACC", "MPC_Z_VEL_I_ACC")
        + triple("MPC_XY_VEL_D_ACC", "MPC_Z_VEL_D_ACC")
        + axes("MC_{}_P")
        + axes("MC_{}RATE_P")
        + axes("MC_{}RATE_I")
        + axes("MC_{}RATE_D")
        + [math.radians(rate) for rate in axes("MC_{}RATE_MAX")]
        + [values[name] for name in (
            "MC_RR_INT_LIM", "MC_YAW_WEIGHT", "MPC_THR_HOVER", "MPC_THR_MAX", "MPC_THR_XY_MARG",
            "MPC_VELD_LP", "IMU_DGYRO_CUTOFF",
        )]
    )  # fmt: skip


class Cascade:
    """Flies a body towards demands."""

    def __init__(self, values: Values, tick: float) -> None:
        self._steps = round(tick / STEP)
        self._memory = np.zeros(24)
        self._setpoint = np.empty(11)
        self._limits = np.empty(5)
        self.retune(values)

    def retune(self, values: Values) -> None:
        """Take the gains anew; the integrals stay."""
        self._gains = gains(values)

    @property
    def collective(self) -> float:
        """Share of the greatest thrust asked for last."""
        return float(self._memory[22])

    @property
    def attitude_wanted(self) -> Vector:
        """(4,) site_from_body asked for last."""
        return self._memory[18:22].copy()

    def forget(self) -> None:
        """Zero the integrals, as PX4 does on the ground."""
        self._memory[0:6] = 0.0

    def fly(self, body: Body, error: Array, demand: Demand, motors: Motors) -> float:
        """Advance `body` by one tick; returns the mean sum of cubed rotor speeds, (rad/s)³."""
        point = self._setpoint
        point[0:3], point[3:6] = demand.position_site, demand.velocity_site
        point[6:9], point[9], point[10] = demand.acceleration_site, demand.yaw_site, demand.yaw_rate
        self._limits[:] = (
            demand.speed, demand.climb, demand.descent, demand.tilt, demand.collective_min,
        )  # fmt: skip
        cubes: float = fly(
            body.state, error, point, self._limits, self._gains, int(motors), body.around,
            body.load, body.constants, STEP, self._steps, self._memory,
        )  # fmt: skip
        return cubes
