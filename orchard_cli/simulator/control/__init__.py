"""PX4's control cascade around the simulated body."""

from .cascade import FREE, Cascade, Demand, Motors

__all__ = ["FREE", "Cascade", "Demand", "Motors"]
