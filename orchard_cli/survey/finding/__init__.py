"""Bare tree positions -> rows, and how sure that is."""

from .find import MOST_TREES, FoundRows, find_rows

__all__ = ["MOST_TREES", "FoundRows", "find_rows"]
