"""The `astar` system's distances."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Attempt:
    """One way to fly the legs that the search finds."""

    cruise: float  # share of the mission's speed
    cut: float  # m: how near the turning points are passed; the search keeps so much more away
    lead: float  # m of free reference before the last turning point, to come back gently


@dataclass(frozen=True, slots=True)
class AstarSettings:
    """Distances besides Limits.clearance and half a cell.

    The paper gives the warning distance, 3 m at 1 to 3 m/s. Where gentle braking from the present
    speed needs more, more is taken: at 1 m/s and 0.5 m/s² it is 4.2 m.
    """

    warning: float = 3.0  # m to the obstacle's surface (Huang 2021, §2.6)
    three_d: bool = False  # search over obstacles, too; else the height is kept
    accept: float = 0.10  # m that a new trajectory keeps
    close: float = 0.05  # m: a trajectory that comes nearer is worth replacing
    below: float = 0.35  # m under the flight height that must be free
    above: float = 0.35  # m over it
    half_size: float = 9.0  # m of the grid
    window: float = 14.0  # m of reference in which a way back is looked for
    ahead: float = 1.0  # m of free reference behind the last turning point
    furthest: float = 5.0  # m beside the route: a longer way round is the pilot's to choose
    highest: float = 2.0  # m over the route, in three dimensions
    vertical: float = 0.6  # m above and below what Limits.clearance is beside
    gentle: float = 0.6  # share of the acceleration limit for early braking
    stop_short: float = 0.2  # m before what blocks
    reserve: float = 0.3  # m of warning distance besides what braking needs
    remember: float = 10.0  # s that an obstacle of the fusion is kept
    attempts: tuple[Attempt, ...] = (
        Attempt(1.0, 0.20, 3.0),
        Attempt(0.8, 0.15, 2.0),
        Attempt(0.6, 0.10, 1.5),
        Attempt(0.45, 0.08, 1.0),
        Attempt(0.3, 0.04, 0.5),
    )
