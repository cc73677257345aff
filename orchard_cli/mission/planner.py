"""An orchard and the crew's wishes become a mission."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.geometry.geodesy import wgs84_from_site
from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.mission import Leg, Mission, Provenance, Segment
from orchard_cli.model.site import Orchard
from orchard_cli.model.trajectory import BSpline, Trajectory
from orchard_cli.model.wishes import FlightWishes
from orchard_cli.motion.fit import (
    RoundedPath,
    distances,
    fit_rounded,
    lengths_of,
    samples,
)
from orchard_cli.motion.timing import PathLimits, TimedPath, time_path

from . import checks, energy, stores, transit
from . import route as routes

DENSITY = 2.0  # control points per metre of route (Liu 2024, §4.1)

_MICRONS = 6  # decimals of a metre kept in a mission: files stay short, and what is saved is exact
_PLACES = 9  # decimals of a degree kept: 0.1 mm


def plan(orchard: Orchard, wishes: FlightWishes, provenance: Provenance) -> Mission:
    """Lay the Π over an orchard, fit its spline, time it, and check it.

    Raises InputError with every fault when the mission cannot be flown safely.
    """
    flown = routes.passes(orchard, wishes)
    if not flown:
        raise InputError(
            Fault("flight.fly_over", "there is nothing to fly over", 'fly over "rows", or add one')
        )
    if faults := transit.end_faults(
        wishes, routes.route(flown, wishes, orchard.terrain).waypoints_site
    ):
        raise InputError(faults)
    return plan_passes(orchard, wishes, provenance, flown)


def plan_passes(
    orchard: Orchard, wishes: FlightWishes, provenance: Provenance, flown: list[routes.Pass]
) -> Mission:
    """As `plan`, over some of the orchard's spray lines."""
    limits = wishes.limits
    route = routes.route(flown, wishes, orchard.terrain)
    waypoints = np.round(route.waypoints_site, _MICRONS)
    length = routes.length(waypoints)
    _refuse_hopeless(orchard, wishes, waypoints, length)
    corners, spline = _fitted(waypoints, wishes.corner_cut, max(8, round(DENSITY * length)))
    curve = samples(spline)
    approach = transit.way(wishes.takeoff_site, waypoints[0], waypoints[1], orchard, wishes)
    departure = transit.way(wishes.landing_site, waypoints[-1], waypoints[-2], orchard, wishes)
    path = np.concatenate([approach[:-1], curve, departure[-2::-1]])
    timed = time_path(path, PathLimits.planned(limits))
    trajectory = _tidy(timed.trajectory)
    reached = _reached(corners, lengths_of(approach)[-1], curve, timed)
    segments = _segments(route, reached, trajectory.end)
    mission = Mission(
        name=orchard.name,
        orchard=orchard,
        waypoints_site=waypoints,
        waypoints_wgs84=_tidy_places(wgs84_from_site(orchard.origin, waypoints)),
        route_length=length,
        corner_cut=wishes.corner_cut,
        spline=spline,
        trajectory=trajectory,
        segments=segments,
        takeoff_site=path[0, :2],
        landing_site=path[-1, :2],
        limits=limits,
        swath=wishes.swath,
        energy_share=round(
            energy.share_over(orchard, path[[0, -1]], trajectory.end, limits), _MICRONS
        ),
        provenance=provenance,
        tank=wishes.tank,
        liquid=_liquid(wishes, flown, segments),
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
    faults = []
    beyond = stores.battery_faults(length / limits.speed / limits.endurance, limits)
    if beyond:
        along = lengths_of(waypoints)
        at = np.linspace(0.0, length, min(int(length / checks.SAMPLING), 50_000) + 2)
        path = np.column_stack([np.interp(at, along, axis) for axis in waypoints.T])
        faults += beyond
        faults += checks.canopy_faults(orchard, limits, path)
        faults += checks.area_faults(orchard, limits, path)
    if faults:
        raise InputError(faults)


def _tidy(trajectory: Trajectory) -> Trajectory:
    control = np.round(trajectory.control_points_site, _MICRONS)
    return Trajectory(trajectory.start, trajectory.interval, control)


def _tidy_places(places_wgs84: Array) -> Array:
    return np.column_stack(
        [np.round(places_wgs84[:, :2], _PLACES), np.round(places_wgs84[:, 2], _MICRONS)]
    )


def _liquid(
    wishes: FlightWishes, flown: list[routes.Pass], segments: tuple[Segment, ...]
) -> float | None:
    """l that the mission sprays; None without a tank."""
    if wishes.tank is None:
        return None
    seconds = sum(s.end - s.start for s in segments if s.leg is Leg.ROW)
    metres = sum(one.length for one in flown)
    return round(wishes.tank.litres(seconds, metres, wishes.swath), _MICRONS)


def _reached(corners: RoundedPath, before: float, curve: Points, timed: TimedPath) -> list[float]:
    """When each waypoint is passed, s.

    A waypoint is reached where the path passes nearest to it: half way round its corner.
    `before` is the length of the way to the first one, m.
    """
    on_spline = np.linspace(0.0, corners.total, len(curve))
    along = np.interp(
        np.concatenate([[0.0], corners.corner_lengths, [corners.total]]),
        on_spline,
        lengths_of(curve),
    )
    return [round(timed.time_at(float(before + s)), _MICRONS) for s in along]


def _segments(route: routes.Route, reached: list[float], end: float) -> tuple[Segment, ...]:
    """Transit, then the route's stretches between the times of their waypoints, then transit."""
    segments = [Segment(Leg.TRANSIT, 0.0, reached[0])]
    for stretch in route.stretches:
        times = segments[-1].end, reached[stretch.until]
        segments.append(Segment(stretch.leg, *times, stretch.row, stretch.until))
    return (*segments, Segment(Leg.TRANSIT, reached[-1], end, until=len(reached) - 1))
