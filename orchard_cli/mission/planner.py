"""An orchard and the crew's wishes become a mission."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.geometry.geodesy import wgs84_from_site
from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.mission import Leg, Limits, Mission, Provenance, Segment
from orchard_cli.model.site import Orchard
from orchard_cli.model.trajectory import BSpline, Trajectory
from orchard_cli.model.wishes import FlightWishes
from orchard_cli.motion.fit import (
    RoundedPath,
    distances,
    fit_rounded,
    lengths_of,
    rounded,
    samples,
)
from orchard_cli.motion.timing import TimedPath, time_path

from . import checks, energy, route

DENSITY = 2.0  # control points per metre of route (Liu 2024, §4.1)
SHARPEST = math.radians(175.0)  # turn between a row and the way to take-off or landing

_MICRONS = 6  # decimals of a metre kept in a mission: files stay short, and what is saved is exact
_PLACES = 9  # decimals of a degree kept: 0.1 mm


def plan(orchard: Orchard, wishes: FlightWishes, provenance: Provenance) -> Mission:
    """Lay the Π over an orchard, fit its spline, time it, and check it.

    Raises InputError with every fault when the mission cannot be flown safely.
    """
    limits = wishes.limits
    waypoints = np.round(route.waypoints(orchard, wishes), _MICRONS)
    length = route.length(waypoints)
    _refuse_hopeless(orchard, wishes, waypoints, length)
    corners, spline = _fitted(waypoints, wishes.corner_cut, max(8, round(DENSITY * length)))
    curve = samples(spline)
    approach, departure = _way_in(wishes, waypoints), _way_out(wishes, waypoints)
    path = np.concatenate([approach[:-1], curve, departure[1:]])
    timed = time_path(path, checks.path_limits(limits))
    trajectory = _tidy(timed.trajectory)
    mission = Mission(
        name=orchard.name,
        orchard=orchard,
        waypoints_site=waypoints,
        waypoints_wgs84=_tidy_places(wgs84_from_site(orchard.origin, waypoints)),
        route_length=length,
        corner_cut=wishes.corner_cut,
        spline=spline,
        trajectory=trajectory,
        segments=_segments(orchard, wishes, corners, approach, curve, timed, trajectory.end),
        takeoff_site=path[0, :2],
        landing_site=path[-1, :2],
        limits=limits,
        swath=wishes.swath,
        energy_share=_energy_share(orchard, path, trajectory, limits),
        provenance=provenance,
    )
    if faults := checks.check(mission):
        raise InputError(faults)
    return mission


def measured_corner_cut(mission: Mission) -> float:
    """Greatest distance from an inner waypoint to the global spline, m."""
    inner = mission.waypoints_site[1:-1]
    return float(distances(inner, samples(mission.spline)).max()) if len(inner) else 0.0


def _fitted(waypoints: Points, cut: float, count: int) -> tuple[RoundedPath, BSpline]:
    """The rounded Π and its spline. Raises InputError where a corner cannot keep the cut."""
    try:
        corners, spline = fit_rounded(waypoints, cut, count)
    except ValueError as error:
        raise InputError(
            Fault("row", f"between two rows: {error}", "let neighbouring rows end side by side")
        ) from error
    spline = BSpline(
        spline.degree,
        np.round(spline.knots, _MICRONS),
        np.round(spline.control_points_site, _MICRONS),
    )
    passed = distances(waypoints[1:-1], samples(spline)) if len(waypoints) > 2 else np.zeros(1)
    if (worst := float(passed.max())) > cut + checks.MICRON:
        raise InputError(
            Fault(
                "flight.corner_cut_m",
                f"the curve leaves waypoint {int(passed.argmax()) + 2} by {worst:.3f} m",
                f"allow {math.ceil(worst * 20) / 20:g}: the spline cannot turn more sharply there",
            )
        )
    return corners, spline


def _refuse_hopeless(
    orchard: Orchard, wishes: FlightWishes, waypoints: Points, length: float
) -> None:
    """Refuse before the costly part: a route beyond the battery, or a take-off in a bad place."""
    limits = wishes.limits
    faults = _end_faults(wishes, waypoints)
    beyond = checks.battery_faults(length / limits.speed / limits.endurance, limits)
    if beyond:
        along = lengths_of(waypoints)
        at = np.linspace(0.0, length, min(int(length / checks.SAMPLING), 50_000) + 2)
        path = np.column_stack([np.interp(at, along, axis) for axis in waypoints.T])
        faults += beyond
        faults += checks.canopy_faults(orchard, limits, path)
        faults += checks.area_faults(orchard, limits, path)
    if faults:
        raise InputError(faults)


def _end_faults(wishes: FlightWishes, waypoints: Points) -> list[Fault]:
    """Take-off or landing on the row's own line: the way there would turn back on itself."""
    faults = []
    for name, site, end, inner in (
        ("takeoff_m", wishes.takeoff_site, waypoints[0], waypoints[1]),
        ("landing_m", wishes.landing_site, waypoints[-1], waypoints[-2]),
    ):
        run = route.run_up_point(end, inner, wishes.limits)
        if site is not None and _turn(site - run[:2], run[:2] - end[:2]) > SHARPEST:
            faults.append(
                Fault(
                    f"flight.{name}",
                    "lies inside the row's line: the vehicle would turn back on itself",
                    f"move it outwards, to ({run[0]:.1f}, {run[1]:.1f}) say, or leave it out",
                )
            )
    return faults


def _turn(a: Vector, b: Vector) -> float:
    """Angle between two (2,) vectors, rad; 0 when one has no length."""
    cross = a[0] * b[1] - a[1] * b[0]
    return abs(math.atan2(float(cross), float(a @ b))) if a.any() and b.any() else 0.0


def _way_in(wishes: FlightWishes, waypoints: Points) -> Points:
    """From above the take-off to the first waypoint, the last stretch in line with its row."""
    run = route.run_up_point(waypoints[0], waypoints[1], wishes.limits)
    return _joined(wishes.takeoff_site, run, waypoints[0], wishes.corner_cut)


def _way_out(wishes: FlightWishes, waypoints: Points) -> Points:
    """From the last waypoint to above the landing, the first stretch in line with its row."""
    run = route.run_up_point(waypoints[-1], waypoints[-2], wishes.limits)
    return _joined(wishes.landing_site, run, waypoints[-1], wishes.corner_cut)[::-1]


def _joined(site: Vector | None, run: Vector, end: Vector, cut: float) -> Points:
    start = run if site is None else np.array([site[0], site[1], run[2]])
    corners = [start, end] if np.linalg.norm(start - run) < 1e-3 else [start, run, end]
    return np.round(rounded(np.array(corners), cut).points_site, _MICRONS)


def _energy_share(orchard: Orchard, path: Points, trajectory: Trajectory, limits: Limits) -> float:
    up, down = (end[2] - orchard.ground_near(end[:2]) for end in (path[0], path[-1]))
    return round(energy.share(trajectory.end, float(up), float(down), limits), _MICRONS)


def _tidy(trajectory: Trajectory) -> Trajectory:
    control = np.round(trajectory.control_points_site, _MICRONS)
    return Trajectory(trajectory.start, trajectory.interval, control)


def _tidy_places(places_wgs84: Array) -> Array:
    return np.column_stack(
        [np.round(places_wgs84[:, :2], _PLACES), np.round(places_wgs84[:, 2], _MICRONS)]
    )


def _segments(
    orchard: Orchard,
    wishes: FlightWishes,
    corners: RoundedPath,
    approach: Points,
    curve: Points,
    timed: TimedPath,
    end: float,
) -> tuple[Segment, ...]:
    """Transit, then rows and headlands by turns between the times of the waypoints, then transit.

    A waypoint is reached where the path passes nearest to it: half way round its corner.
    """
    on_spline = np.linspace(0.0, corners.total, len(curve))
    reached = np.interp(
        np.concatenate([[0.0], corners.corner_lengths, [corners.total]]),
        on_spline,
        lengths_of(curve),
    )
    before = lengths_of(approach)[-1]
    times = [round(timed.time_at(float(before + s)), _MICRONS) for s in reached]
    order = route.row_order(orchard, wishes)
    segments = [Segment(Leg.TRANSIT, 0.0, times[0])]
    for k, (a, b) in enumerate(pairwise(times)):
        row = order[k // 2][0] if k % 2 == 0 else None
        segments.append(Segment(Leg.HEADLAND if row is None else Leg.ROW, a, b, row, k + 1))
    return (*segments, Segment(Leg.TRANSIT, times[-1], end, until=len(times) - 1))
