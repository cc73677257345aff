"""What every message is made of, and MAVLink's integer units."""

from __future__ import annotations

from dataclasses import dataclass

from orchard_cli.simulator.autopilot import Autopilot

from .earth import Earth, Told


@dataclass(frozen=True, slots=True)
class Scope:
    """The autopilot, its estimate in MAVLink's frames, and UTC."""

    autopilot: Autopilot
    earth: Earth
    told: Told
    utc: float  # s, Unix time of boot


def e7(degrees: float) -> int:
    """Degrees in MAVLink's 1e-7."""
    return round(degrees * 1e7)


def mm(metres: float) -> int:
    """Metres in millimetres."""
    return round(metres * 1000)
