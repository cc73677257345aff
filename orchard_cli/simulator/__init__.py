"""The embedded simulator: world, renderer, body, autopilot (MAVLink)."""

from .lockstep import LockstepSimulator
from .process import AttachedSimulator, SharedSimulator, SimulatorProcess
from .settings import SimulatorSettings

__all__ = [
    "AttachedSimulator",
    "LockstepSimulator",
    "SharedSimulator",
    "SimulatorProcess",
    "SimulatorSettings",
]
