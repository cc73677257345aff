"""The avoidance systems, each fits the socket `Avoidance` in flight/ports.py."""

from .astar import Astar, AstarSettings
from .automaton import AutomatonSettings, Dfa
from .ego import Ego, EgoSettings
from .guided import Guided, GuidedSettings
from .none import Blind
from .zones import Zones, ZonesSettings

__all__ = [
    "Astar",
    "AstarSettings",
    "AutomatonSettings",
    "Blind",
    "Dfa",
    "Ego",
    "EgoSettings",
    "Guided",
    "GuidedSettings",
    "Zones",
    "ZonesSettings",
]
