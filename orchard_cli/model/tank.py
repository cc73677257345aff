"""A sprayer with a tank: what the liquid does to its weight, its inertia and its limits.

After Ahmed 2022, §2.1.1 and §2.2.1; the text that we have lost its minus and fraction signs, and
each equation says what was restored.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from .mission import Limits

GRAVITY = 9.80665


@dataclass(frozen=True, slots=True)
class Sprayer:
    """A quadrotor that carries a tank under its centre (Ahmed 2022, Table 2).

    The liquid is a rigid block on the tank's floor: its level goes from 0 to 1 (eq. 3), and
    nothing sloshes. Table 2 prints the inertia as "0.3933 e 1" and "0.76 e 1" with a sign lost:
    e-1 or e1 would put the frame's mass 4 or 44 cm from its middle, on arms of 50 cm. 0.3933 and
    0.76 kg m², 14 and 19 cm, are taken.
    """

    name: str = "sprayer"
    mass: float = 20.0  # kg, empty (M_D)
    inertia: tuple[float, float, float] = (0.3933, 0.3933, 0.76)  # kg m², empty, x y z of the body
    arm: float = 0.5  # m, centre to the end of an arm (l_DA)
    thrust_max: float = 4 * 13.5 * GRAVITY  # N, all rotors (u_Tmax)
    liquid_max: float = 32.0  # kg (M_LQmax)
    tank: tuple[float, float, float] = (0.4, 0.4, 0.2)  # m, length, width, height (l_T, w_T, h_T)
    tank_below: float = 0.4  # m from the frame's centre down to the tank's (d_DT)
    radius: float = 0.8  # m, centre to the rotors' tips: 24-inch propellers at the arms' ends
    density: float = 1.0  # kg/l
    flow: float = 2.0  # l/min, all nozzles

    def liquid(self, level: float) -> float:
        """kg of liquid (eq. 4)."""
        return self.liquid_max * level

    def mass_at(self, level: float) -> float:
        """kg, all of it (eq. 5)."""
        return self.mass + self.liquid(level)

    def centre_below(self, level: float) -> float:
        """m from the frame's centre down to the centre of mass of the whole: d_SD (eqs. 9-11)."""
        return self._liquid_below(level) * self.liquid(level) / self.mass_at(level)

    def _liquid_below(self, level: float) -> float:
        """m down to the liquid's centre: -C_ML = d_DT + h_T / 2 - h_T P_LQ / 2 (eq. 9)."""
        return self.tank_below + 0.5 * self.tank[2] * (1.0 - level)

    def inertia_at(self, level: float) -> tuple[float, float, float]:
        """kg m² about the centre of mass of the whole (eqs. 6-8, 13-15)."""
        length, width, height = self.tank
        liquid, filled = self.liquid(level), height * level
        to_frame = self.centre_below(level)
        to_liquid = self._liquid_below(level) - to_frame
        moved = self.mass * to_frame**2 + liquid * to_liquid**2
        return (
            self.inertia[0] + liquid * (filled**2 + width**2) / 12 + moved,
            self.inertia[1] + liquid * (filled**2 + length**2) / 12 + moved,
            self.inertia[2] + liquid * (length**2 + width**2) / 12,
        )

    def tilt_max(self, level: float) -> float:
        """rad: the greatest tilt that still carries the weight, times M_D / M (eqs. 18-19)."""
        mass = self.mass_at(level)
        return self.mass / mass * math.acos(min(mass * GRAVITY / self.thrust_max, 1.0))

    def acceleration_max(self, level: float) -> float:
        """m/s², horizontal, at the greatest tilt (eq. 17)."""
        return GRAVITY * math.tan(self.tilt_max(level))

    def slowdown(self, speed: float, level: float) -> float:
        """m from `speed` m/s to rest: d_SD = v² / (2 g tan tilt_max) (eqs. 17 and 19)."""
        return speed**2 / (2 * self.acceleration_max(level))

    def litres(self, level: float) -> float:
        """l in the tank."""
        return self.liquid(level) / self.density


@dataclass(frozen=True, slots=True)
class Load:
    """A sprayer and how full it is."""

    vehicle: Sprayer
    level: float  # 0 to 1

    def after(self, pumped: float) -> Load:
        """When the pump has run for that many seconds: never below empty."""
        share = self.vehicle.flow / 60 * self.vehicle.density / self.vehicle.liquid_max
        return Load(self.vehicle, max(0.0, self.level - share * pumped))

    @property
    def empty(self) -> bool:
        """Nothing left to spray."""
        return self.level <= 0.0

    def limits(self, limits: Limits) -> Limits:
        """The mission's limits as this vehicle can keep them with this load."""
        most = min(limits.acceleration, self.vehicle.acceleration_max(self.level))
        return replace(
            limits,
            acceleration=most,
            acceleration_along=min(limits.acceleration_along, most),
            airframe_radius=max(limits.airframe_radius, self.vehicle.radius),
            clearance=max(limits.clearance, 2 * self.vehicle.arm),
        )


SPRAYER = Sprayer()
