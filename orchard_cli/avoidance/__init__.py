"""The avoidance systems, each fits the socket `Avoidance` in flight/ports.py."""

from .guided import Guided, GuidedSettings
from .none import Blind

__all__ = ["Blind", "Guided", "GuidedSettings"]
