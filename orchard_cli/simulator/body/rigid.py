"""The rigid body's state."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from orchard_cli.model.arrays import Array, Vector
from orchard_cli.model.tank import Load

from ._kernels import DRAG_ROTOR, K_THRUST, SPEED_IDLE, SPEED_MAX, derivative, rk4
from .airframe import Airframe


class Body:
    """Position, velocity, attitude, rates and rotor speeds, and the load that they carry.

    `ground` is the plane (a, b, c): z = a x + b y + c. `around` is the air and the ground as the
    kernels take them; its first three are the wind.
    """

    def __init__(
        self,
        airframe: Airframe,
        start_site: tuple[float, float],
        yaw_site: float,
        ground: Sequence[float] = (0.0, 0.0, 0.0),
        level: float = 0.0,
    ) -> None:
        self.airframe = airframe
        self.constants = airframe.flat()
        self.load = airframe.load(level)
        self.level = level
        self.state = np.zeros(17)
        self.state[:2] = start_site
        self.around = np.array([0.0, 0.0, 0.0, *ground])
        self.state[2] = self.ground_height
        self.state[6] = math.cos(yaw_site / 2)
        self.state[9] = math.sin(yaw_site / 2)
        self._work = np.empty((5, 17))

    @property
    def position_site(self) -> Vector:
        """(3,) m, a copy."""
        return self.state[0:3].copy()

    @property
    def velocity_site(self) -> Vector:
        """(3,) m/s, a copy."""
        return self.state[3:6].copy()

    @property
    def site_from_body(self) -> Vector:
        """(4,) quaternion w, x, y, z, a copy."""
        return self.state[6:10].copy()

    @property
    def rates_body(self) -> Vector:
        """(3,) rad/s, a copy."""
        return self.state[10:13].copy()

    @property
    def ground_height(self) -> float:
        """z of the ground below, m."""
        a, b, c = self.around[3:].tolist()
        x, y = self.state[:2].tolist()
        return float(a * x + b * y + c)

    @property
    def airborne(self) -> bool:
        """Whether it is clear of the ground; standing, it sinks in by some millimetres."""
        return bool(self.state[2] > self.ground_height)

    def pump(self, seconds: float) -> None:
        """Spray for so long; nothing comes out of an empty tank."""
        tank = self.airframe.tank
        if tank is not None and self.level > 0.0:
            self.level = Load(tank, self.level).after(seconds).level
            self.load[:] = self.airframe.load(self.level)

    def break_rotors(self) -> None:
        """From now on no thrust, no drag and no power of the rotors, whatever they are told."""
        self.state[13:17] = 0.0
        self.constants[[K_THRUST, DRAG_ROTOR, SPEED_MAX, SPEED_IDLE]] = 0.0

    def derivative(self, speeds_wanted: Array) -> Array:
        """(17,) time derivative of the state under wanted rotor speeds (4,) rad/s."""
        out = np.empty(17)
        derivative(self.state, speeds_wanted, self.around, self.load, self.constants, out)
        return out

    def step(self, speeds_wanted: Array, dt: float) -> None:
        """Advance by `dt` seconds with a fourth-order Runge-Kutta step."""
        rk4(self.state, speeds_wanted, self.around, self.load, self.constants, dt, self._work)
