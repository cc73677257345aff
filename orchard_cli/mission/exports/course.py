"""A mission as other tools fly it: places joined by straight legs, each with the pump on or off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.errors import Fault
from orchard_cli.geometry.geodesy import apart, wgs84_from_site
from orchard_cli.model.arrays import Array, Points, frozen
from orchard_cli.model.mission import Leg, Mission
from orchard_cli.model.site import HeightReference
from orchard_cli.motion.straightening import straightened

CENTIMETRE = 0.01
_TRANSIT = 0.1  # m by which a transit's straight legs may leave the flown curve
_STEP = 0.1  # s between samples of a transit


@dataclass(frozen=True, slots=True)
class Way:
    """What the straight leg between two places is for."""

    leg: Leg
    row: int | None  # index into Orchard.rows while spraying

    @property
    def sprays(self) -> bool:
        """The pump runs along rows and nowhere else."""
        return self.leg is Leg.ROW


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """The places that a mission visits, from above take-off to above landing."""

    name: str
    points_site: Points  # (n, 3) m
    places_wgs84: Array  # (n, 3) latitude deg, longitude deg, height m by `reference`
    heights: Array  # (n,) m above the ground at take-off
    clear: Array  # (n,) m above the ground below
    ways: tuple[Way, ...]  # n - 1, from each place to the next
    home_wgs84: Array  # (3,) take-off on the ground
    landing_wgs84: Array  # (3,) landing on the ground
    reference: HeightReference
    fence_wgs84: Array  # (k, 2) latitude, longitude; empty: none
    keep_outs_wgs84: tuple[Array, ...]  # each (k, 2)
    speed: float  # m/s

    def __post_init__(self) -> None:
        n = len(self.points_site)
        for name, shape in (
            ("points_site", (n, 3)), ("places_wgs84", (n, 3)), ("heights", (n,)), ("clear", (n,)),
        ):  # fmt: skip
            object.__setattr__(self, name, frozen(getattr(self, name), shape, name))


@dataclass(frozen=True, slots=True, eq=False)
class Loaded:
    """What a reader found in an exported file."""

    places_wgs84: Array  # (n, 2) latitude deg, longitude deg
    heights: Array  # (n,) m above the ground at take-off
    sprays: tuple[bool, ...]  # n - 1
    fence_wgs84: Array | None = None  # (k, 2); None: the format carries none
    keep_outs_wgs84: tuple[Array, ...] | None = None


def course(mission: Mission) -> Course:
    """The Π's own waypoints; the ways to it and from it as few straight legs."""
    pieces: list[Points] = []
    ways: list[Way] = []
    begin = 0
    last = len(mission.segments) - 1
    for k, segment in enumerate(mission.segments):
        points = mission.waypoints_site[begin : segment.until + 1]
        if segment.leg is Leg.TRANSIT and k in (0, last):
            ends = (segment.start, segment.end)
            points = _transit(mission, *ends)
            points[-1 if k == 0 else 0] = mission.waypoints_site[segment.until]
        if len(points) > 1:
            pieces.append(points[:-1])
            ways += [Way(segment.leg, segment.row)] * (len(points) - 1)
            tail = points[-1:]
        begin = segment.until
    return _placed(mission, np.concatenate([*pieces, tail]), tuple(ways))


def _transit(mission: Mission, start: float, end: float) -> Points:
    """The flown curve between two times of the trajectory, in few points."""
    times = np.linspace(start, end, max(2, int((end - start) / _STEP)))
    return np.array(straightened(mission.trajectory.sample(times)[0], _TRANSIT))


def _placed(mission: Mission, points: Points, ways: tuple[Way, ...]) -> Course:
    orchard, origin = mission.orchard, mission.orchard.origin
    ground = np.array([orchard.ground_near(point[:2]) for point in points])

    def on_earth(ring: Points) -> Array:
        level = np.column_stack([ring, np.zeros(len(ring))])
        return wgs84_from_site(origin, level)[:, :2]

    ends = np.array(
        [
            [*site, orchard.ground_near(site)]
            for site in (mission.takeoff_site, mission.landing_site)
        ]
    )
    home, landing = wgs84_from_site(origin, ends)
    return Course(
        name=mission.name,
        points_site=points,
        places_wgs84=wgs84_from_site(origin, points),
        heights=points[:, 2] - mission.takeoff_ground,
        clear=points[:, 2] - ground,
        ways=ways,
        home_wgs84=home,
        landing_wgs84=landing,
        reference=origin.height_reference,
        fence_wgs84=on_earth(orchard.fence_site),
        keep_outs_wgs84=tuple(on_earth(ring) for ring in orchard.keep_outs_site),
        speed=mission.limits.speed,
    )


def differences(course: Course, loaded: Loaded) -> list[Fault]:
    """Where a file, read back, is not the course: geometry to a centimetre, pump leg by leg."""
    faults = _apart("the route", course.places_wgs84[:, :2], loaded.places_wgs84)
    if not faults:
        high = np.abs(course.heights - loaded.heights)
        if high.max() > CENTIMETRE:
            k = int(high.argmax())
            faults.append(Fault("the route", f"point {k + 1} is {high[k]:.3f} m off in height"))
    pump = tuple(way.sprays for way in course.ways)
    if pump != loaded.sprays:
        faults.append(Fault("the pump", "does not run along the same legs"))
    if loaded.fence_wgs84 is not None:
        faults += _apart("the fence", course.fence_wgs84, loaded.fence_wgs84)
    if loaded.keep_outs_wgs84 is not None:
        if len(loaded.keep_outs_wgs84) != len(course.keep_outs_wgs84):
            faults.append(Fault("the keep-outs", "are not as many"))
        for k, (a, b) in enumerate(
            zip(course.keep_outs_wgs84, loaded.keep_outs_wgs84, strict=False), 1
        ):
            faults += _apart(f"keep-out {k}", a, b)
    return faults


def _apart(what: str, a_wgs84: Array, b_wgs84: Array) -> list[Fault]:
    if len(a_wgs84) != len(b_wgs84):
        return [Fault(what, f"has {len(b_wgs84)} points, not {len(a_wgs84)}")]
    if not len(a_wgs84):
        return []
    metres = apart(a_wgs84, b_wgs84)
    if metres.max() <= CENTIMETRE:
        return []
    k = int(metres.argmax())
    return [Fault(what, f"point {k + 1} is {metres[k]:.3f} m off")]
