"""The avoidance systems, each fits the socket `Avoidance` in flight/ports.py."""

from .ego import Ego, EgoSettings
from .guided import Guided, GuidedSettings
from .none import Blind
from .zones import Zones, ZonesSettings

__all__ = ["Blind", "Ego", "EgoSettings", "Guided", "GuidedSettings", "Zones", "ZonesSettings"]
