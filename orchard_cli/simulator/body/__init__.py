"""The simulated body: a rigid quadrotor in wind and on the ground."""

from .airframe import X500, Airframe, sprayer
from .normals import Normals
from .rigid import Body
from .wind import Gusts

__all__ = ["X500", "Airframe", "Body", "Gusts", "Normals", "sprayer"]
