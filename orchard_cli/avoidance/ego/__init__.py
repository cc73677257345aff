"""The `ego` system: EGO-Planner (Zhou et al. 2020), written from its paper. See docs/ego.md."""

from .settings import EgoSettings
from .system import Ego

__all__ = ["Ego", "EgoSettings"]
