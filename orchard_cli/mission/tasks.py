"""Tasks in a row become a mission: straight legs from rest to rest, and hovers between them.

Wang 2020, §3.7: take-off, straight flight to a point, hover for a time, landing, freely combined.
Take-off and landing themselves are the autopilot's. Nothing is sprayed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.geometry.geodesy import wgs84_from_site
from orchard_cli.model.arrays import Points
from orchard_cli.model.mission import Leg, Limits, Mission, Provenance, Segment
from orchard_cli.model.site import Orchard
from orchard_cli.model.tasks import FlyTo, Hover, TakeOff, Task
from orchard_cli.model.trajectory import DEGREE, BSpline, Trajectory
from orchard_cli.model.wishes import FlightWishes
from orchard_cli.motion.fit import fit_rounded
from orchard_cli.motion.timing import PathLimits, time_path

from . import checks, energy

_DENSITY = 2.0  # control points of the global spline per metre
_SHORTEST = 1.0  # m of a leg
_MICRONS, _PLACES = 6, 9  # decimals of a metre, and of a degree


def plan_tasks(
    orchard: Orchard, wishes: FlightWishes, provenance: Provenance, tasks: Sequence[Task]
) -> Mission:
    """A mission of tasks, the first a take-off and the last a landing.

    Raises InputError with every fault when it cannot be flown safely.
    """
    limits, start = wishes.limits, tasks[0]
    if not isinstance(start, TakeOff):
        raise ValueError("tasks begin with a take-off")
    ground = orchard.ground_near(start.place_site)
    points, control, reached = _flown(start, tasks, ground, limits)
    if len(points) < 2:
        raise InputError(Fault("task", "leads nowhere", 'add a task with do = "fly"'))
    trajectory = Trajectory(0.0, _interval(limits), np.round(control, _MICRONS))
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    wgs84 = wgs84_from_site(orchard.origin, points)
    mission = Mission(
        name=orchard.name,
        orchard=orchard,
        waypoints_site=points,
        waypoints_wgs84=np.column_stack(
            [np.round(wgs84[:, :2], _PLACES), np.round(wgs84[:, 2], _MICRONS)]
        ),
        route_length=length,
        corner_cut=wishes.corner_cut,
        spline=_spline(points, length, wishes.corner_cut),
        trajectory=trajectory,
        segments=_segments(reached, trajectory.end),
        takeoff_site=points[0, :2],
        landing_site=points[-1, :2],
        limits=limits,
        swath=wishes.swath,
        energy_share=round(
            energy.share_over(orchard, points[[0, -1]], trajectory.end, limits), _MICRONS
        ),
        provenance=provenance,
    )
    if faults := checks.check(mission):
        raise InputError(faults)
    return mission


def _interval(limits: Limits) -> float:
    return 0.5 / limits.speed


def _flown(
    start: TakeOff, tasks: Sequence[Task], ground: float, limits: Limits
) -> tuple[Points, Points, list[float]]:
    """Waypoints (n, 3) m, control points (k, 3) m, and when each waypoint is reached, s."""
    interval = _interval(limits)
    here = np.round(np.array([*start.place_site, ground + start.height]), _MICRONS)
    points, control = [here], [here] * (DEGREE + 1)
    reached, faults = [interval], []
    for k, task in enumerate(tasks, 1):
        if isinstance(task, Hover):
            control += [here] * math.ceil(task.seconds / interval)
        elif isinstance(task, FlyTo):
            z = here[2] if task.height is None else ground + task.height
            there = np.round(np.array([*task.place_site, z]), _MICRONS)
            if float(np.linalg.norm(there[:2] - here[:2])) < _SHORTEST:
                what = f"is a leg of less than {_SHORTEST:g} m"
                faults.append(Fault(f"task {k}", what, "leave it out, or fly farther"))
                continue
            leg = time_path(np.stack([here, there]), PathLimits.planned(limits), interval)
            control += [*leg.trajectory.control_points_site, *[there] * DEGREE]
            reached.append(round((len(control) - DEGREE) * interval, _MICRONS))
            points.append(there)
            here = there
    if faults:
        raise InputError(faults)
    control += [here] * DEGREE  # stands, and then lands
    return np.array(points), np.array(control), reached


def _spline(points: Points, length: float, cut: float) -> BSpline:
    """The global spline: it rounds the corners at which the vehicle stops."""
    try:
        _, spline = fit_rounded(points, cut, max(8, round(_DENSITY * length)))
    except ValueError as error:
        mend = "fly there by way of another place"
        raise InputError(Fault("task", f"{error}", mend)) from error
    return BSpline(
        spline.degree,
        np.round(spline.knots, _MICRONS),
        np.round(spline.control_points_site, _MICRONS),
    )


def _segments(reached: Sequence[float], end: float) -> tuple[Segment, ...]:
    """Standing above the take-off, the legs, and standing above the landing."""
    segments = [Segment(Leg.TRANSIT, 0.0, reached[0])]
    for k, time in enumerate(reached[1:], 1):
        segments.append(Segment(Leg.HEADLAND, segments[-1].end, time, until=k))
    return (*segments, Segment(Leg.TRANSIT, reached[-1], end, until=len(reached) - 1))
