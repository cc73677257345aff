"""Which zone, and what to do there: by category and quadrant (Wang 2020, §3.5, Figs. 3-4)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

from orchard_cli.model.obstacles import Category, Obstacle
from orchard_cli.motion.path import Path

from .points import Way
from .settings import ZonesSettings


class Zone(Enum):
    """From far to near (Fig. 3)."""

    CLEAR = "clear"
    WARNING = "warning"
    ACTION = "action"
    EMERGENCY = "emergency"


class Act(Enum):
    """What to do."""

    FLY_ON = "fly on"
    SLOW_DOWN = "slow down"
    AVOID = "avoid"
    HOVER = "hover"


@dataclass(frozen=True, slots=True)
class Ahead:
    """An obstacle as the path meets it."""

    obstacle: Obstacle
    along: float  # m of path to where its axis is abeam
    aside: float  # m of its axis to the left of the path
    path_height: float  # m, z of the path there

    @property
    def near(self) -> float:
        """m of path to its surface."""
        return self.along - self.obstacle.width / 2

    def d_x(self, half: float) -> float:
        """m between the passing area's side and the obstacle's; negative: it reaches in."""
        return abs(self.aside) - self.obstacle.width / 2 - half

    def d_z(self, below: float) -> float:
        """m between the passing area's lower side and the obstacle's top; negative: it reaches
        in."""
        return self.path_height - below - self.obstacle.top

    def over_head(self, above: float) -> float:
        """m between the obstacle's lower end and the passing area's upper side."""
        return self.obstacle.bottom - (self.path_height + above)


def ahead_on(path: Path, obstacle: Obstacle) -> Ahead:
    """An obstacle as a path meets it."""
    along, aside = path.beside(obstacle.centre_site)
    return Ahead(obstacle, along, aside, float(path.at(along)[2]))


@dataclass(frozen=True, slots=True)
class Decision:
    """What to do, and because of what."""

    zone: Zone
    act: Act
    why: str
    ahead: Ahead | None = None
    ways: tuple[Way, ...] = ()  # the first is the paper's, the others are tried when it is not free
    alarm: bool = False  # the pilot must hear of it


ALIVE = (Category.PERSON, Category.DRONE)
LEAPT = (Category.TREE, Category.BUILDING)


def decide(
    seen: Iterable[Ahead], glimpsed: Category | None, below: float, s: ZonesSettings
) -> Decision:
    """Judge what is ahead, the nearest that is in the way. Nothing but the arguments counts.

    `glimpsed`: something in the way whose distance is not known; `below`: m under the path that
    must be free.
    """
    meets = sorted((one for one in seen if in_the_way(one, below, s)), key=lambda one: one.near)
    for one in meets:
        zone = zone_of(one.near, s)
        what = f"{one.obstacle.category.value} in {max(one.near, 0.0):.1f} m"
        if zone is Zone.EMERGENCY:
            return Decision(zone, Act.HOVER, what, one, alarm=True)
        if zone is Zone.ACTION:
            if one.obstacle.category in ALIVE:
                return Decision(zone, Act.HOVER, what, one, alarm=True)
            return Decision(zone, Act.AVOID, what, one, ways(one, below, s))
        if zone is Zone.WARNING:
            return Decision(zone, Act.SLOW_DOWN, what, one)
    if glimpsed is not None:
        return Decision(Zone.WARNING, Act.SLOW_DOWN, f"{glimpsed.value} far ahead")
    return Decision(Zone.CLEAR, Act.FLY_ON, "free")


def zone_of(near: float, s: ZonesSettings) -> Zone:
    """The zone that a distance lies in."""
    if near < s.emergency:
        return Zone.EMERGENCY
    if near < s.action:
        return Zone.ACTION
    return Zone.WARNING if near < s.warning else Zone.CLEAR


def in_the_way(one: Ahead, below: float, s: ZonesSettings) -> bool:
    """Whether an obstacle reaches into the passing area, or a person or drone near the path."""
    if one.along <= 0.0:
        return False
    if one.obstacle.category in ALIVE:
        return one.d_x(s.people) < 0.0
    return one.d_x(s.half) < 0.0 and one.d_z(below) < 0.0 and one.over_head(s.half) < 0.0


def ways(one: Ahead, below: float, s: ZonesSettings) -> tuple[Way, ...]:
    """Ways past an obstacle, the paper's first.

    Centre in the lower half of the image: over it when it is a tree or a building low enough to
    leap; else away from the side on which it stands. A wire has no end to go round.
    """
    aside = Way.RIGHT if one.aside > 0.0 else Way.LEFT
    other = Way.LEFT if aside is Way.RIGHT else Way.RIGHT
    low = float(one.obstacle.centre_site[2]) < one.path_height
    leap = one.obstacle.category in LEAPT and low and -one.d_z(below) <= s.highest_leap
    if one.obstacle.category is Category.WIRE:
        return ()
    return (Way.OVER, aside, other) if leap else (aside, other)
