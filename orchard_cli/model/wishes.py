"""What the crew asks of a flight, apart from the orchard itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from .arrays import Vector, frozen
from .mission import Limits


class HeightAbove(Enum):
    """What the flight height is measured from."""

    GROUND = "ground"
    CANOPY = "canopy"


class StartRow(Enum):
    """Which row is flown first."""

    FIRST = "first"
    LAST = "last"


class StartSide(Enum):
    """From which end the first flown row is entered: near is the side of the rows' first trees."""

    NEAR = "near"
    FAR = "far"


@dataclass(frozen=True, slots=True, eq=False)
class FlightWishes:
    """How an orchard shall be flown."""

    height: float  # m
    height_above: HeightAbove = HeightAbove.GROUND
    start_row: StartRow = StartRow.FIRST
    start_side: StartSide = StartSide.NEAR
    swath: float = 3.0  # m
    corner_cut: float = 0.5  # m, greatest distance from a Π corner to the curve
    takeoff_site: Vector | None = None  # (2,) m; None: in line, before the first tree flown over
    landing_site: Vector | None = None  # (2,) m; None: in line, behind the last tree flown over
    limits: Limits = field(default_factory=Limits)

    def __post_init__(self) -> None:
        for name in ("takeoff_site", "landing_site"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, frozen(getattr(self, name), (2,), name))
