"""Where the flight stands, and what was decided."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from orchard_cli.model.vehicle import Command

from .safety import Hazard, Phase


class Steer(Enum):
    """What the setpoint stream does."""

    NOTHING = "nothing"  # no stream: the autopilot flies by its own mode
    STAND = "stand"  # brake along the trajectory, then stand
    JOIN = "join"  # go to the route's next point and look along it
    FOLLOW = "follow"  # fly the route
    GO_BACK = "go back"  # fly the way home
    DIVERT = "divert"  # go straight to the stage's place


@dataclass(frozen=True, slots=True)
class Stage:
    """Where the flight stands, since when, and why."""

    phase: Phase
    since: float  # s, flight clock
    why: str
    cause: Hazard | None = None  # what led here, when safety did
    asked: Command | None = None  # newest command, and when
    asked_at: float = 0.0
    as_planned: bool = True  # False once the flight has been ended early
    returning: bool = False  # on the way home, also while held there
    engaged: bool = False  # the autopilot was seen in the mode that the phase asks for
    holds: int = 0  # holds so far
    place_site: tuple[float, float] | None = None  # m, where it diverts to


@dataclass(frozen=True, slots=True)
class Decision:
    """What to do in this cycle."""

    stage: Stage
    steer: Steer
    command: Command | None
    hazards: tuple[Hazard, ...]  # those that matter in this phase
