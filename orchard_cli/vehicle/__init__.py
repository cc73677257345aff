"""The MAVSDK link and the deadman."""

from .clock import MonotonicClock
from .deadman import Deadman
from .link import MavsdkVehicle, connect

__all__ = ["Deadman", "MavsdkVehicle", "MonotonicClock", "connect"]
