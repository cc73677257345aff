"""The embedded simulator: world, renderer, body, autopilot (MAVLink)."""

from .lockstep import LockstepSimulator
from .process import SimulatorProcess
from .settings import SimulatorSettings

__all__ = ["LockstepSimulator", "SimulatorProcess", "SimulatorSettings"]
