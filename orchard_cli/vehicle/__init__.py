"""The MAVSDK link and the deadman."""

from .clock import MonotonicClock
from .deadman import Deadman
from .inspection import LinkReport, inspect_link
from .link import MavsdkVehicle, connect

__all__ = ["Deadman", "LinkReport", "MavsdkVehicle", "MonotonicClock", "connect", "inspect_link"]
