"""Rules about the pump: it runs along the rows that the mission names, and nowhere else."""

from __future__ import annotations

import numpy as np
import shapely

from orchard_cli.model.mission import Mission

from .flown import Flown
from .report import Finding, Rule, Sense, judge_along, judge_total

_NEARER = 0.5  # m by which another row may be nearer: between two rows either is right
_ASKEW = 0.3  # rad between a spray line and its row


def spray_findings(mission: Mission, flown: Flown) -> list[Finding]:
    """While the pump runs the vehicle is on the line between the row's first and last tree."""
    rule = Rule("pump on, beside the row", Sense.AT_MOST, mission.corner_cut, "m", 0.05)
    findings: list[Finding] = []
    worst: Finding | None = None
    for segment, points in mission.spray_lines:
        if len(points) < 2 or segment.row is None:
            findings += judge_total(rule, np.inf, "a row without a line")
            continue
        line = shapely.LineString(points[:, :2])
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
    if not findings:
        findings = [worst] if worst is not None else judge_total(rule, 0.0, "nothing is sprayed")
    return [*findings, *_named_rows(mission)]


def _named_rows(mission: Mission) -> list[Finding]:
    """Each spray line lies at the row that it names, not at another one, and runs along it."""
    near = Rule("spray line at its row", Sense.AT_MOST, _NEARER, "m")
    straight = Rule("spray line along its row", Sense.AT_MOST, _ASKEW, "rad")
    rows = [row.trunks_site for row in mission.orchard.rows]
    lines = np.array([shapely.LineString(trunks) for trunks in rows])
    off, askew = [(0.0, "nothing is sprayed")], [(0.0, "nothing is sprayed")]
    for segment, points in mission.spray_lines:
        if segment.row is None or segment.row >= len(rows):
            off.append((np.inf, f"there is no row {segment.row}"))
            continue
        away = shapely.distance(lines, shapely.Point(points[:, :2].mean(axis=0)))
        way = points[-1, :2] - points[0, :2]
        planted = rows[segment.row][-1] - rows[segment.row][0]
        cross = way[0] * planted[1] - way[1] * planted[0]
        turn = abs(float(np.arctan2(cross, abs(way @ planted))))
        about = f"row {segment.row + 1}"
        off.append((float(away[segment.row] - away.min()), about))
        askew.append((turn, about))
    worst_off, worst_askew = max(off, key=_first), max(askew, key=_first)
    return [*judge_total(near, *worst_off), *judge_total(straight, *worst_askew)]


def _first(found: tuple[float, str]) -> float:
    return found[0]
