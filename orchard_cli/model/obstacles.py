"""What is seen in images: detections, and the obstacles that depth makes of them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from .arrays import Vector, frozen


class Category(Enum):
    """What a thing is. Wang 2020, §2.1, has one class for power lines and their poles and towers;
    here it is two: a pole can be passed on either side, a wire cannot."""

    PERSON = "person"
    TREE = "tree"
    BUILDING = "building"
    POLE = "pole"
    WIRE = "wire"
    DRONE = "drone"


@dataclass(frozen=True, slots=True)
class Detection:
    """A thing's box in an image. Pixel u covers u - 0.5 to u + 0.5."""

    category: Category
    score: float  # 0 to 1
    left: float  # px
    top: float  # px
    right: float  # px
    bottom: float  # px
    near: float = 0.0  # m: its surface's least and
    far: float = math.inf  # m: greatest depth, where the detector knows them

    def __post_init__(self) -> None:
        if not (self.left < self.right and self.top < self.bottom and 0.0 <= self.score <= 1.0):
            raise ValueError("a detection needs a box with an inside and a score in 0 to 1")

    @property
    def centre(self) -> tuple[float, float]:
        """Column and row of P_c, px (Wang 2020, §3.3)."""
        return (self.left + self.right) / 2, (self.top + self.bottom) / 2


@dataclass(frozen=True, slots=True, eq=False)
class Obstacle:
    """A detection with its distance, size and place (Wang 2020, eqs. 1-2)."""

    detection: Detection
    depth: float  # m along the optical axis to its surface
    width: float  # m across the line of sight
    centre_site: Vector  # (3,) m, on its upright axis, half way between bottom and top
    bottom: float  # m, z in the site frame
    top: float  # m, z in the site frame
    cut: bool = False  # the image's left or right edge cuts it: it may be wider

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre_site", frozen(self.centre_site, (3,), "centre"))

    @property
    def category(self) -> Category:
        """What it is."""
        return self.detection.category

    @property
    def height(self) -> float:
        """m from its bottom to its top, as far as it was seen."""
        return self.top - self.bottom


@dataclass(frozen=True, slots=True)
class Sighting:
    """What one look found."""

    obstacles: tuple[Obstacle, ...] = ()
    glimpses: tuple[Detection, ...] = ()  # without a distance: known by category and box alone


@dataclass(frozen=True, slots=True, eq=False)
class Upright:
    """What radar and camera together know of one thing: an upright cylinder (Huang 2021, §2.2)."""

    time: float  # s, flight clock, of the image
    distance: float  # m, level, from the body's centre to its surface
    width: float  # m
    centre_site: Vector  # (2,) m, its axis
    bottom: float  # m, z in the site frame
    top: float  # m, z in the site frame
    cut: bool = False  # the image's edge cuts it: it may be larger

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre_site", frozen(self.centre_site, (2,), "centre"))

    @property
    def height(self) -> float:
        """m from its bottom to its top, as far as it was seen."""
        return self.top - self.bottom
