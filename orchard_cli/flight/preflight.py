"""Reasons not to arm."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.mission import Mission
from orchard_cli.model.vehicle import Landed, VehicleState

from .boundary import ROUNDING, area_of
from .safety import Tolerances

START_TOLERANCE = 5.0  # m between the vehicle and the mission's take-off point


def not_ready(
    mission: Mission,
    vehicle: VehicleState | None,
    frame_age: float,
    planner_age: float,
    tolerances: Tolerances,
) -> tuple[str, ...]:
    """Every reason against arming, in words with the mend; empty when there is none."""
    if vehicle is None:
        return ("no position, attitude or mode heard from the autopilot yet",)
    reasons = list(vehicle.not_ready)
    away = float(np.linalg.norm(vehicle.position_site[:2] - mission.takeoff_site))
    if not away <= START_TOLERANCE:
        x, y = mission.takeoff_site
        reasons.append(
            f"the vehicle stands {away:.1f} m from the take-off point ({x:.1f}, {y:.1f}); "
            f"carry it there, at most {START_TOLERANCE:.0f} m off"
        )
    inside = area_of(mission).margins(vehicle.position_site[None])[0]
    if inside < mission.limits.airframe_radius - ROUNDING:
        reasons.append("the vehicle stands outside the fence, in a keep-out, or on their edge")
    if vehicle.landed is not Landed.ON_GROUND:
        reasons.append(
            f"the autopilot does not say that it is on the ground ({vehicle.landed.value})"
        )
    needed = mission.energy_share + mission.limits.reserve
    if math.isnan(vehicle.battery_share):
        reasons.append("the battery's charge is not known")
    elif vehicle.battery_share < needed:
        reasons.append(
            f"battery at {vehicle.battery_share:.0%}, the mission and its reserve need "
            f"{needed:.0%}; change the battery"
        )
    if frame_age > tolerances.frame_age:
        reasons.append(
            "no fresh depth frames with returns in them; check the camera, and that it "
            "sees anything"
        )
    elif planner_age > tolerances.planner_age:
        reasons.append("the map does not follow the frames yet")
    return tuple(reasons)
