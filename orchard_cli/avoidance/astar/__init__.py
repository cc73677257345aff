"""The `astar` system: improved A* on a map, after Huang et al. 2021."""

from .settings import AstarSettings
from .system import Astar, Fusion

__all__ = ["Astar", "AstarSettings", "Fusion"]
