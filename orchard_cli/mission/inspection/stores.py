"""Rules about what a flight uses up: time and battery."""

from __future__ import annotations

from orchard_cli.mission import energy
from orchard_cli.model.mission import Mission

from .flown import Flown
from .report import Finding, Rule, Sense, judge_total
from .terrain import Terrain


def store_findings(mission: Mission, flown: Flown, terrain: Terrain) -> list[Finding]:
    """Duration and energy, counted anew from the trajectory."""
    limits = mission.limits
    airborne = float(flown.times[-1] - flown.times[0])
    ends = flown.positions[[0, -1]]
    up, down = ends[:, 2] - terrain.ground(ends[:, :2])
    share = energy.share(airborne, float(up), float(down), limits)
    usable = 1 - limits.reserve
    return [
        *judge_total(
            Rule("duration", Sense.AT_MOST, usable * limits.endurance, "s", 1e-6),
            airborne,
            f"{limits.endurance:g} s of battery less {limits.reserve:.0%}",
        ),
        *judge_total(
            Rule("energy", Sense.AT_MOST, usable, "of the battery", 1e-6),
            share,
            "from arming to landing",
        ),
        *judge_total(
            Rule("stated energy", Sense.AT_MOST, mission.energy_share, "of the battery", 1e-3),
            share,
            "as the mission file promises it",
        ),
    ]
