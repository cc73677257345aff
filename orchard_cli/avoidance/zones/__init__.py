"""`zones`: what is ahead decides, by its category and how near it is (Wang et al. 2020)."""

from .settings import ZonesSettings
from .system import Zones

__all__ = ["Zones", "ZonesSettings"]
