"""The rolling occupancy grid and its distance field."""

from .band import Band
from .distance import DistanceField, distance_field
from .grid import OccupancyGrid
from .insert import InsertReport
from .settings import GridSettings
from .window import Window

__all__ = [
    "Band",
    "DistanceField",
    "GridSettings",
    "InsertReport",
    "OccupancyGrid",
    "Window",
    "distance_field",
]
