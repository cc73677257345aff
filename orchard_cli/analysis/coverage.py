"""What was sprayed, on the ground: Ahmed 2022, eqs. 30-31."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from orchard_cli.model.arrays import Points
from orchard_cli.model.flown import FlownLog, Track
from orchard_cli.model.mission import Leg, Mission

from .figures import Unknown
from .lines import trajectory_points

TOLERANCE = 0.02  # m: a flown line is simplified this much before it is widened to a strip

SWITCHES = 2000  # times that a pump may be switched on before the log is not believed


@dataclass(frozen=True, slots=True)
class Coverage:
    """How well the planned strips were treated."""

    percent: float  # of the planned strips' area that was sprayed
    overlap_percent: float  # of the sprayed area that was sprayed again
    missed_strip_m: float  # longest stretch of a planned spray line that was not sprayed


@dataclass(frozen=True, slots=True, eq=False)
class Areas:
    """What the ground got, as polygons in the site frame, m."""

    planned: BaseGeometry  # the strips of all rows that the mission sprays: A_CI
    treated: BaseGeometry  # everything that was sprayed: A
    doubled: BaseGeometry  # sprayed at least twice
    sprayed_area: float  # m², of all strips, each counted whole

    @property
    def missed(self) -> BaseGeometry:
        """Planned and not sprayed."""
        return self.planned.difference(self.treated)


def areas(lines: Sequence[Points], flown: Sequence[Points], swath: float) -> Areas:
    """Planned spray lines and lines flown with the pump on, as strips; each (n, 2) m, n >= 2."""
    ideal = shapely.union_all([_strip(shapely.LineString(line), swath) for line in lines])
    strips = [_strip(shapely.LineString(line), swath) for line in flown]
    tree = shapely.STRtree(strips)
    pairs = [
        strip.intersection(strips[other])
        for i, strip in enumerate(strips)
        for other in tree.query(strip)
        if other > i
    ]
    return Areas(
        planned=ideal,
        treated=shapely.union_all(strips) if strips else shapely.Polygon(),
        doubled=shapely.union_all(pairs) if pairs else shapely.Polygon(),
        sprayed_area=sum(strip.area for strip in strips),
    )


def coverage(log: FlownLog, mission: Mission) -> Coverage | Unknown:
    """Compare the strips flown with the pump on with the strips that the mission plans."""
    lines = planned_lines(mission)
    if not lines:
        return Unknown("the mission plans no spraying")
    if not log.spray:
        return Unknown("the log says nothing about the pump")
    flown = flown_lines(log)
    if len(flown) > SWITCHES:
        return Unknown(f"the pump was switched on more than {SWITCHES} times")
    return compare(lines, flown, mission.swath)


def compare(lines: Sequence[Points], flown: Sequence[Points], swath: float) -> Coverage:
    """Planned spray lines against lines flown with the pump on; each (n, 2) m, n >= 2."""
    found = areas(lines, flown, swath)
    ideal, treated = found.planned, found.treated
    plans = [shapely.LineString(line) for line in lines]
    missed = [part.length for line in plans for part in _parts(line.difference(treated))]
    twice = max(0.0, found.sprayed_area - treated.area)
    return Coverage(
        percent=100.0 * ideal.intersection(treated).area / ideal.area,
        overlap_percent=100.0 * twice / treated.area if treated.area > 0 else 0.0,
        missed_strip_m=max(missed, default=0.0),
    )


def planned_lines(mission: Mission) -> list[Points]:
    """(n, 2) m for each row that the mission sprays."""
    return [
        trajectory_points(mission.trajectory, s.start, s.end)[:, :2]
        for s in mission.segments
        if s.leg is Leg.ROW and s.end > s.start
    ]


def flown_lines(log: FlownLog) -> list[Points]:
    """(n, 2) m for each time that the pump ran; it runs until a record says otherwise."""
    lines = []
    since: float | None = None
    for record in log.spray:
        if record.on and since is None:
            since = record.time
        elif not record.on and since is not None:
            lines.append(_between(log.odometry, since, record.time))
            since = None
    if since is not None:
        lines.append(_between(log.odometry, since, np.inf))
    return [line for line in lines if len(line) > 1]


def _between(track: Track, start: float, end: float) -> Points:
    return track.between(start, end).positions_site[:, :2]


def _strip(line: BaseGeometry, swath: float) -> BaseGeometry:
    """Flat ends: nothing is treated before the pump starts or after it stops."""
    return line.simplify(TOLERANCE).buffer(swath / 2, cap_style="flat", join_style="round")


def _parts(geometry: BaseGeometry) -> list[BaseGeometry]:
    return list(shapely.get_parts(geometry))
