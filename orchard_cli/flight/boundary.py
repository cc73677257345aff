"""The fence and the keep-outs, judged in flight: for every avoidance system alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.geometry.area import Area
from orchard_cli.model.arrays import Vector
from orchard_cli.model.mission import Limits, Mission
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import VehicleState
from orchard_cli.motion.braking import brake
from orchard_cli.motion.situation import Avoid, Stop, Verdict

LOOK_AHEAD = 8.0  # s of what is flown that must stay inside
SPACING = 0.1  # m between the places looked at
ROUNDING = 0.05  # m less than the planner kept


@dataclass(frozen=True, slots=True)
class Margins:
    """How far inside the allowed area, m; negative: outside."""

    here: float  # of the vehicle's centre
    ahead: float  # of where full braking would end


NO_EDGE = Margins(np.inf, np.inf)


def area_of(mission: Mission) -> Area:
    """Where a mission may be flown."""
    return Area(mission.orchard.fence_site, mission.orchard.keep_outs_site)


def margins(area: Area, vehicle: VehicleState, shift_site: Vector, deceleration: float) -> Margins:
    """Judged where the vehicle is by the flight and by the autopilot, `shift_site` m apart."""
    if area.unbounded:
        return NO_EDGE
    here = np.asarray(vehicle.position_site)[:2]
    velocity = vehicle.velocity_site[:2]
    end = here + velocity * float(np.linalg.norm(velocity)) / (2 * deceleration)
    told = shift_site[:2]
    found = area.margins(np.stack([here, here - told, end, end - told]))
    return Margins(float(found[:2].min()), float(found[2:].min()))


def bounded(
    verdict: Verdict, active: Trajectory, now: float, commit: float, area: Area, limits: Limits
) -> Verdict:
    """The verdict, or a stop where what is to be flown would leave the area.

    The vehicle's outline stays inside, as the planner of missions keeps it.
    """
    if area.unbounded or isinstance(verdict, Stop):
        return verdict
    way = verdict.trajectory if isinstance(verdict, Avoid) else active
    until = max(now + LOOK_AHEAD, verdict.rejoin if isinstance(verdict, Avoid) else now)
    times = np.arange(now, min(until, way.end) + 1e-9, SPACING / limits.speed)
    out = area.leaves(way.sample(times)[0], limits.airframe_radius - ROUNDING)
    if out is None:
        return verdict
    what = "the way round" if isinstance(verdict, Avoid) else "what is flown"
    return Stop(
        brake(active, commit, limits.acceleration),
        f"{what} would leave the fence or enter a keep-out",
        blocked_at=out * SPACING,
        stages_ms=verdict.stages_ms,
    )
