"""The mission: everything that is decided before take-off."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from .arrays import Array, Points, Vector, frozen
from .site import Orchard
from .trajectory import BSpline, Trajectory

WAYPOINT_PASSED = 2.0
"""m beside a waypoint within which it counts as passed: one that a pole stands on is passed so."""


@dataclass(frozen=True, slots=True)
class Limits:
    """What the vehicle may do on this mission."""

    speed: float = 1.0  # m/s
    acceleration: float = 0.5  # m/s², length of the whole vector
    acceleration_along: float = 0.27  # m/s², speeding up and braking (Liu 2024, §5.2)
    yaw_rate: float = 0.8  # rad/s
    climb_speed: float = 0.7  # m/s
    clearance: float = 0.85  # m, airframe's centre to any obstacle's surface, never less
    airframe_radius: float = 0.35  # m, centre to the outermost rotor tip
    endurance: float = 600.0  # s of hover on a full battery (Liu 2024, §6.1)
    reserve: float = 0.2  # share of the battery that must be left at landing


class Leg(Enum):
    """What a stretch of the route is for."""

    TRANSIT = "transit"
    ROW = "row"
    HEADLAND = "headland"


@dataclass(frozen=True, slots=True)
class Segment:
    """A stretch of the trajectory in mission time; spray is on along rows only."""

    leg: Leg
    start: float  # s since the trajectory's start
    end: float  # s
    row: int | None = None  # index into Orchard.rows: the row that is treated
    until: int = 0  # index of the waypoint that is reached at its end; transits reach none


@dataclass(frozen=True, slots=True)
class Tank:
    """What is sprayed, and how much of it there is. One of flow and dose is given."""

    capacity: float  # l that may be sprayed
    flow: float | None = None  # l/s through all nozzles while the pump runs
    dose: float | None = None  # l/m² on the ground, by a pump that follows the speed

    def litres(self, seconds: float, metres: float, swath: float) -> float:
        """What spraying `metres` of line takes, m wide `swath`, in `seconds`."""
        if self.flow is not None:
            return self.flow * seconds
        return (self.dose or 0.0) * metres * swath


@dataclass(frozen=True, slots=True)
class Sortie:
    """One of the flights that an orchard takes."""

    number: int  # from 1
    of: int


@dataclass(frozen=True, slots=True)
class Provenance:
    """Where a mission came from."""

    survey: str  # file name
    survey_sha256: str
    tool_version: str
    created_utc: str  # ISO 8601


@dataclass(frozen=True, slots=True, eq=False)
class Mission:
    """A planned flight: Π waypoints, their global B-spline, and the timed trajectory to fly.

    The trajectory starts at rest above `takeoff_site`, runs through the route and ends at rest
    above `landing_site`; its clock starts at 0 and the runner shifts it to the flight clock.
    """

    name: str
    orchard: Orchard
    waypoints_site: Points  # (n, 3) m, the Π's corners in flight order
    waypoints_wgs84: Array  # (n, 3) latitude deg, longitude deg, height m as the origin's reference
    route_length: float  # m along the Π from the first waypoint to the last
    corner_cut: float  # m, bound on the distance from a Π corner to the curve
    spline: BSpline
    trajectory: Trajectory
    segments: tuple[Segment, ...]
    takeoff_site: Vector  # (2,) m
    landing_site: Vector  # (2,) m
    limits: Limits
    swath: float  # m, width treated by one pass
    energy_share: float  # of the battery, estimated from take-off to landing
    provenance: Provenance
    tank: Tank | None = None  # None: the survey says nothing of it
    liquid: float | None = None  # l, estimated; None without a tank
    sortie: Sortie | None = None  # None: the whole orchard in one flight

    def __post_init__(self) -> None:
        for name, shape in (
            ("waypoints_site", (None, 3)),
            ("waypoints_wgs84", (None, 3)),
            ("takeoff_site", (2,)),
            ("landing_site", (2,)),
        ):
            object.__setattr__(self, name, frozen(getattr(self, name), shape, name))

    @property
    def duration(self) -> float:
        """Seconds from the first waypoint reached to the last, as planned."""
        start = next(s.start for s in self.segments if s.leg is not Leg.TRANSIT)
        end = next(s.end for s in reversed(self.segments) if s.leg is not Leg.TRANSIT)
        return end - start

    @property
    def spray_lines(self) -> tuple[tuple[Segment, Points], ...]:
        """Each stretch with the pump on, and its waypoints (k, 3) m, k >= 2, as flown."""
        begins = [0, *(s.until for s in self.segments[:-1])]
        return tuple(
            (segment, self.waypoints_site[begin : segment.until + 1])
            for segment, begin in zip(self.segments, begins, strict=True)
            if segment.leg is Leg.ROW
        )

    def planned_speed(self, segment: Segment) -> float:
        """m/s half way along a segment, in time: rows begin and end in bends, which are slower."""
        middle = self.trajectory.at((segment.start + segment.end) / 2)
        return math.hypot(*middle.velocity_site[:2].tolist())

    @property
    def takeoff_ground(self) -> float:
        """z of the ground at the take-off point, m in the site frame."""
        return self.orchard.ground_near(self.takeoff_site)

    @property
    def takeoff_height(self) -> float:
        """Metres above the take-off ground at which the trajectory starts."""
        return float(self.trajectory.control_points_site[0, 2]) - self.takeoff_ground

    @property
    def highest(self) -> float:
        """Metres above the take-off ground of the route's highest waypoint."""
        return float(self.waypoints_site[:, 2].max()) - self.takeoff_ground

    @property
    def flight_height_site(self) -> float:
        """z of the trajectory's start, m: where take-off ends."""
        return float(self.trajectory.control_points_site[0, 2])
