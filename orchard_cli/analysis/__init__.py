"""Log -> metrics, coverage, comparison, picture, page."""

from .figures import Avoidance, Clearances, Metrics, Unknown
from .flight import Flight, names
from .metrics import measure

__all__ = ["Avoidance", "Clearances", "Flight", "Metrics", "Unknown", "measure", "names"]
