"""The embedded simulator: world, renderer, body, autopilot (MAVLink).

Loaded when asked for: a reader of world files needs none of the kernels.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
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

_HOMES = {
    "AttachedSimulator": "process",
    "LockstepSimulator": "lockstep",
    "SharedSimulator": "process",
    "SimulatorProcess": "process",
    "SimulatorSettings": "settings",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)
