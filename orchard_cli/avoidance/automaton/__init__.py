"""Ahmed 2022: the finite automaton that avoids on radar and four lasers."""

from .course import steered
from .numbers import AutomatonSettings, Drift
from .system import Dfa

__all__ = ["AutomatonSettings", "Dfa", "Drift", "steered"]
