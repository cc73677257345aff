"""What sensors see of a world: exact depth and ranges, then a stereo pair's errors."""

from .beams import cast
from .colour import colour_image
from .draw import Painter, Shapes
from .stereo import stereo_image

__all__ = ["Painter", "Shapes", "cast", "colour_image", "stereo_image"]
