"""The `guided` system: path-guided B-spline replanning after Liu et al. 2024, §4."""

from .settings import Attempt, GuidedSettings
from .system import Guided

__all__ = ["Attempt", "Guided", "GuidedSettings"]
