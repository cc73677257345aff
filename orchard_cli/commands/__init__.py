"""The door: one file per verb; wiring.py plugs the sockets."""

from .app import main

__all__ = ["main"]
