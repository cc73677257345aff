"""The mission that a ground station uploads: MAVLink items, already in the site frame."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from orchard_cli.model.arrays import Vector


class Does(IntEnum):
    """MAV_CMD of the items that are understood; others are passed as soon as they are reached."""

    WAYPOINT = 16
    RETURN = 20
    LAND = 21
    TAKEOFF = 22
    DELAY = 93
    CHANGE_SPEED = 178


MOVES = frozenset({Does.WAYPOINT, Does.LAND, Does.TAKEOFF})
"""Commands with a place to fly to."""


@dataclass(frozen=True, slots=True, eq=False)
class Item:
    """One item. `target_site` is None for commands without a place."""

    command: int
    params: tuple[float, float, float, float]
    target_site: Vector | None  # (3,) m

    @property
    def moves(self) -> bool:
        """Whether it has a place to fly to."""
        return self.command in MOVES and self.target_site is not None
