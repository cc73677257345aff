"""Rules about the earth: the mission's two lists of waypoints name the same places."""

from __future__ import annotations

import numpy as np

from orchard_cli.geometry.geodesy import apart, wgs84_by_geodesics
from orchard_cli.model.mission import Mission

from .report import Finding, Rule, Sense

_NEAR = 0.05  # m, and 10 ppm of the distance from the origin
_EARTH = 6.371e6  # m


def place_findings(mission: Mission) -> list[Finding]:
    """Each waypoint walked to from the origin by heading and distance, along geodesics."""
    origin, sites = mission.orchard.origin, mission.waypoints_site
    told = mission.waypoints_wgs84
    walked = wgs84_by_geodesics(origin, sites)
    far = np.hypot(sites[:, 0], sites[:, 1])
    level = apart(walked, told) - 1e-5 * far
    height = np.abs(walked[:, 2] - told[:, 2]) - far**2 / _EARTH
    findings = []
    for name, figures in (("places on earth", level), ("heights on earth", height)):
        rule = Rule(name, Sense.AT_MOST, _NEAR, "m")
        worst = int(figures.argmax())
        figure = float(max(figures[worst], 0.0))
        about = f"waypoint {worst + 1} against the site frame"
        findings.append(Finding(rule, rule.keeps(figure), figure, about, sites[worst]))
    return findings
