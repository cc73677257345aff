"""What the crew asks of a flight, apart from the orchard itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from .arrays import Vector, frozen
from .mission import Limits, Tank


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


class FlyOver(Enum):
    """What the spray lines lie above."""

    ROWS = "rows"
    BETWEEN = "between"


class Pattern(Enum):
    """In which order the spray lines are flown."""

    EVERY = "every"  # one after the other
    OUT_AND_BACK = "out_and_back"  # every second one, then the others on the way back
    ALTERNATE = "alternate"  # every second one, the others not at all


class Direction(Enum):
    """Whether neighbouring lines are flown to and fro, or all the same way."""

    BOTH = "both"
    ONE_WAY = "one_way"


class Turn(Enum):
    """The shape of a turn on the headland."""

    SQUARE = "square"
    ROUNDED = "rounded"
    LOOP = "loop"


class Follow(Enum):
    """Whether a line stays straight over its row, or goes up and down with what is below it."""

    LINE = "line"
    TERRAIN = "terrain"


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
    fly_over: FlyOver = FlyOver.ROWS
    passes: int = 1  # for each row, or each gap between rows
    overlap: float | None = None  # share of the swath; not None: as many passes as that takes
    pattern: Pattern = Pattern.EVERY
    direction: Direction = Direction.BOTH
    turn: Turn = Turn.SQUARE
    headland: float = 0.0  # m beyond the last tree where turns begin
    turn_radius: float = 3.0  # m, of a loop
    follow: Follow = Follow.LINE
    tank: Tank | None = None

    def __post_init__(self) -> None:
        for name in ("takeoff_site", "landing_site"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, frozen(getattr(self, name), (2,), name))
