"""Rules about what a flight uses up: time, battery and liquid."""

from __future__ import annotations

import numpy as np

from orchard_cli.mission import energy
from orchard_cli.model.mission import Mission

from .flown import Flown
from .report import Finding, Rule, Sense, judge_total
from .terrain import Terrain

_DROP = 0.01  # share: corners cut make the flown line shorter than the waypoints'


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
        *_liquid(mission, flown),
    ]


def _liquid(mission: Mission, flown: Flown) -> list[Finding]:
    """What is sprayed, counted along the flight, against the tank."""
    tank = mission.tank
    if tank is None:
        return judge_total(Rule("liquid", Sense.AT_MOST, np.inf, "l"), 0.0, "no tank is told of")
    on = np.zeros(len(flown.times), dtype=bool)
    for segment, _ in mission.spray_lines:
        on |= (flown.times >= segment.start) & (flown.times < segment.end)
    steps = np.gradient(flown.times)
    seconds, metres = float(steps[on].sum()), float((steps * flown.speeds)[on].sum())
    litres = tank.litres(seconds, metres, mission.swath)
    about = f"{metres:.0f} m in {seconds:.0f} s with the pump on"
    holds = Rule("liquid", Sense.AT_MOST, tank.capacity, "l", _DROP * tank.capacity)
    stated = Rule("stated liquid", Sense.AT_MOST, mission.liquid or 0.0, "l", _DROP * litres)
    return [
        *judge_total(holds, litres, about),
        *judge_total(stated, litres, "as the mission file promises it"),
    ]
