"""MAVLink as PX4 speaks it on its onboard link."""

from .endpoint import Endpoint
from .udp import UdpLink

__all__ = ["Endpoint", "UdpLink"]
