"""The MAVSDK link and the deadman."""

from .deadman import Deadman
from .link import MavsdkVehicle, connect

__all__ = ["Deadman", "MavsdkVehicle", "connect"]
