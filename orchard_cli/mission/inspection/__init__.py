"""A second look at a mission, as a pilot takes it before flying.

It judges the trajectory as it will be flown, by code that shares nothing with the planner but the
nouns: SciPy's splines for the motion, solids for what stands, geodesics for the places on earth. A
wrong sign in one of the two is seen by the other.
"""

from __future__ import annotations

from orchard_cli.mission.checks import check
from orchard_cli.model.mission import Mission
from orchard_cli.model.world import World

from .flown import flown
from .motion import motion_findings
from .places import place_findings
from .report import Finding, Rule, Sense, judge_total
from .space import HeightBand, space_findings
from .spraying import spray_findings
from .stores import store_findings
from .terrain import Terrain

__all__ = ["Finding", "HeightBand", "Rule", "Sense", "inspect"]

HIGHEST = 120.0  # m above ground: the open category's ceiling (EU 2019/947, UAS.OPEN.010)


def inspect(
    mission: Mission, world: World | None = None, band: HeightBand | None = None
) -> list[Finding]:
    """Judge every rule. `band` is by default from the clearance up to HIGHEST."""
    band = band or HeightBand(mission.limits.clearance, HIGHEST)
    longest = Rule("duration", Sense.AT_MOST, mission.limits.endurance, "s")
    if not longest.keeps(mission.trajectory.end):  # nothing to gain from looking closer
        return judge_total(longest, mission.trajectory.end, "longer than the battery lasts")
    path, terrain = flown(mission.trajectory), Terrain(mission.orchard)
    faults = check(mission)
    whole = Rule("the file agrees with itself", Sense.AT_MOST, 0, "faults")
    return [
        *space_findings(mission, path, terrain, band, world),
        *motion_findings(path, mission.limits),
        *store_findings(mission, path, terrain),
        *spray_findings(mission, path),
        *place_findings(mission),
        *judge_total(whole, len(faults), "; ".join(map(str, faults))),
    ]
