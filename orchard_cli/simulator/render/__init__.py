"""What a depth camera sees of a world: exact depth, then a stereo pair's errors."""

from .draw import Painter
from .stereo import stereo_image

__all__ = ["Painter", "stereo_image"]
