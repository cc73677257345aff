"""The battery: charge that goes with power, and the voltage that it shows."""

from __future__ import annotations

from dataclasses import dataclass

from orchard_cli.simulator.body import Airframe

IDLE_SHARE = 0.03
"""Power of the electronics, as a share of hover power."""

RESISTANCE = 0.02  # Ω, of pack and leads


@dataclass(frozen=True, slots=True)
class Pack:
    """Endurance after Liu 2024, §6.1 (about ten minutes); the capacity is a common 4S pack's."""

    endurance: float = 600.0  # s of hover from full to empty
    capacity: float = 5.0  # Ah


class Battery:
    """Remaining share of a pack, drained in proportion to the sum of cubed rotor speeds."""

    def __init__(self, pack: Pack, airframe: Airframe) -> None:
        self._pack = pack
        self._hover = 4 * airframe.hover_speed**3
        self.share = 1.0
        self.current = 0.0  # A

    def drain(self, cubes: float, dt: float) -> None:
        """Use `dt` seconds at this mean sum of cubed rotor speeds, (rad/s)³."""
        power = IDLE_SHARE + (1 - IDLE_SHARE) * cubes / self._hover  # of hover
        self.share = max(0.0, self.share - power * dt / self._pack.endurance)
        self.current = power * self._pack.capacity * 3600 / self._pack.endurance

    @property
    def used_mah(self) -> float:
        """Charge taken since full, mAh."""
        return (1 - self.share) * self._pack.capacity * 1000

    def voltage(self, cells: float, empty: float, charged: float) -> float:
        """V at the terminals: linear in the charge, less the drop by the current."""
        return cells * (empty + (charged - empty) * self.share) - self.current * RESISTANCE
