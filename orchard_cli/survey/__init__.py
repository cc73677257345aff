"""Survey files -> Orchard and the crew's wishes."""

from .load import Survey, load, parse

__all__ = ["Survey", "load", "parse"]
