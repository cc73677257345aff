"""What the simulated quadrotor is made of."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array
from orchard_cli.model.tank import SPRAYER, Sprayer

from ._kernels import GRAVITY


@dataclass(frozen=True, slots=True)
class Airframe:
    """A quadrotor in X. Its reference point is the centre of mass, and stands at z = 0 on its feet.

    Default: Holybro X500 as in PX4-gazebo-models, x500_base and x500 (mass, inertia, arms, thrust,
    moment, rotor drag, rotor speeds). Chosen here: one motor lag for up and down (there 0.0125 and
    0.025 s); the body's drag as a plate of 0.04 m² (0.5 · 1.225 kg/m³ · 1.0 · 0.04 m²); the ground,
    stiff enough to stand on within 4 mm; the radius, that of missions' limits: arms with the
    10-inch propellers of Liu 2024 reach 0.30 m along the body's axes and 0.37 m over its diagonals.
    """

    mass: float = 2.0 + 4 * 0.0161  # kg, with rotors
    inertia: tuple[float, float, float] = (0.0217, 0.0217, 0.04)  # kg m², x y z of the body
    arm: float = 0.174  # m, of each rotor along x and along y
    thrust: float = 8.54858e-6  # N / (rad/s)²
    moment: float = 0.016  # m, reaction torque per thrust
    speed_max: float = 1000.0  # rad/s
    speed_idle: float = 150.0  # rad/s, armed on the ground
    lag: float = 0.02  # s, first order, of a rotor's speed
    drag_rotor: float = 8.06428e-5  # N / (rad/s · m/s), per rotor, in its plane
    drag_body: float = 0.0245  # N / (m/s)²
    ground_spring: float = 1250.0  # N/m, each foot
    ground_damper: float = 35.0  # N/(m/s), each foot
    friction: float = 0.7
    tank: Sprayer | None = None  # what a load does to it
    radius: float = 0.35  # m, of the ball around the reference point that stands for the airframe

    @property
    def thrust_max(self) -> float:
        """N, all rotors together."""
        return 4 * self.thrust * self.speed_max**2

    @property
    def hover_share(self) -> float:
        """Share of the greatest thrust that carries the weight."""
        return self.mass * GRAVITY / self.thrust_max

    @property
    def hover_speed(self) -> float:
        """rad/s of each rotor when it hovers in still air."""
        return self.speed_max * math.sqrt(self.hover_share)

    def flat(self) -> Array:
        """(11,) as the kernels take it."""
        return np.array(
            [self.thrust, self.moment, self.arm, self.lag, self.speed_max,
             self.speed_idle, self.drag_rotor, self.drag_body, self.ground_spring,
             self.ground_damper, self.friction]
        )  # fmt: skip

    def load(self, level: float = 0.0) -> Array:
        """(5,) mass, inertia, and the rotors' height over the centre of mass, for the kernels."""
        if self.tank is None:
            return np.array([self.mass, *self.inertia, 0.0])
        tank = self.tank
        below = tank.centre_below(level)
        return np.array([tank.mass_at(level), *tank.inertia_at(level), below])


X500 = Airframe()


def sprayer(tank: Sprayer = SPRAYER) -> Airframe:
    """Ahmed 2022's quadrotor with a tank; `arm` is along x and along y, at 45 degrees.

    Mass, inertia, arms and greatest thrust are the paper's. Chosen here, for it says nothing:
    24-inch propellers at 4,000 rpm, a motor lag of 50 ms, 0.03 m of reaction torque per thrust,
    rotor drag of the same share of the weight as the X500's, a plate of 0.25 m², and a ground as
    stiff for the weight.
    """
    top = 420.0  # rad/s
    return Airframe(
        mass=tank.mass,
        inertia=tank.inertia,
        arm=tank.arm * math.sqrt(0.5),
        thrust=tank.thrust_max / 4 / top**2,
        moment=0.03,
        speed_max=top,
        speed_idle=60.0,
        lag=0.05,
        drag_rotor=2.0e-3,
        drag_body=0.153,
        ground_spring=32000.0,
        ground_damper=900.0,
        tank=tank,
        radius=tank.radius,
    )
