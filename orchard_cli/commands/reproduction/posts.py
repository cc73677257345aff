"""Something to see before a take-off: without it a vehicle may not arm."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from orchard_cli.model.mission import Mission


def posts(flown: Mission, height: float) -> str:
    """Two poles of that height, m, ahead of where a mission takes off, for a world file."""
    x, y = (float(value) for value in flown.takeoff_site)
    return "".join(
        f"[[pole]]\nx_m = {x + 4.0}\ny_m = {y + side}\nradius_m = 0.2\nheight_m = {height}\n"
        for side in (-1.0, 1.0)
    )
