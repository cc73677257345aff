"""Log -> metrics, coverage, comparison, picture."""

from .figures import Avoidance, Clearances, Metrics, Unknown
from .metrics import measure

__all__ = ["Avoidance", "Clearances", "Metrics", "Unknown", "measure"]
