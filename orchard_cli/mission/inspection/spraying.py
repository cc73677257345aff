"""Rules about the pump: it runs along the rows that the mission names, and nowhere else."""

from __future__ import annotations

import numpy as np
import shapely

from orchard_cli.model.mission import Leg, Mission

from .flown import Flown
from .report import Finding, Rule, Sense, judge_along, judge_total


def spray_findings(mission: Mission, flown: Flown) -> list[Finding]:
    """While the pump runs the vehicle is on the line between the row's first and last tree."""
    rule = Rule("pump on, beside the row", Sense.AT_MOST, mission.corner_cut, "m", 0.05)
    findings: list[Finding] = []
    worst: Finding | None = None
    for segment in mission.segments:
        if segment.leg is not Leg.ROW or segment.row is None:
            continue
        if segment.row >= len(mission.orchard.rows):
            findings += judge_total(rule, np.inf, f"there is no row {segment.row + 1}")
            continue
        line = shapely.LineString(mission.orchard.rows[segment.row].trunks_site[[0, -1]])
        on = (flown.times >= segment.start) & (flown.times <= segment.end)
        if not on.any():
            continue
        part = Flown(
            flown.times[on], flown.positions[on], flown.velocities[on], flown.accelerations[on]
        )
        beside = shapely.distance(line, shapely.points(part.positions[:, :2]))
        found = judge_along(rule, part, np.asarray(beside), f"row {segment.row + 1}")
        findings += [f for f in found if not f.ok]
        worst = max([f for f in (worst, *found) if f is not None], key=lambda f: f.figure)
    if findings:
        return findings
    return [worst] if worst is not None else judge_total(rule, 0.0, "nothing is sprayed")
