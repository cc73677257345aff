"""The last look before a contact: is anything in the way nearer than hard braking needs?

It does without map and planner, which are there to keep it from ever being asked: one image, where
the vehicle is, and how it moves.
"""

from __future__ import annotations

import numpy as np

from orchard_cli.geometry.rotations import matrix
from orchard_cli.model.arrays import Points
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.vehicle import VehicleState

HARD = 2.0  # m/s² of braking in an emergency; PX4 gives 3 (MPC_ACC_HOR)
REACTION = 0.3  # s from the exposure until braking bites
SPARE = 0.1  # m around the airframe
SLOW = 0.15  # m/s under which nothing is braked
BLOCK = 4  # every so many pixels are looked at
ENOUGH = 6  # of them: fewer are noise


def needed(speed: float, radius: float) -> float:
    """m from the airframe's centre within which nothing may be in the way at a speed, m/s."""
    return speed * REACTION + speed**2 / (2 * HARD) + radius + SPARE


def too_near(frame: DepthFrame, state: VehicleState, radius: float) -> bool:
    """Whether something stands in the tube that the airframe (radius, m) sweeps, within `needed`.

    The tube is straight, along the velocity; what is in it counts as seen in ENOUGH pixels.
    """
    speed = float(np.linalg.norm(state.velocity_site))
    if speed < SLOW:
        return False
    reach = needed(speed, radius)
    points = _within(frame, reach + float(np.linalg.norm(frame.camera.position_body)))
    if len(points) < ENOUGH:
        return False
    away = points @ matrix(state.site_from_body).T
    along = away @ (state.velocity_site / speed)
    aside = np.sqrt(np.maximum((away * away).sum(axis=1) - along * along, 0.0))
    inside = (along > 0.0) & (along <= reach) & (aside <= radius + SPARE)
    return int(inside.sum()) >= ENOUGH


def _within(frame: DepthFrame, reach: float) -> Points:
    """(n, 3) m in the body frame: what the pixels looked at show, up to `reach` m deep."""
    camera = frame.camera
    depth = frame.depth_mm[::BLOCK, ::BLOCK]
    v, u = np.nonzero((depth > 0) & (depth <= reach * 1000))
    seen = camera.points(u * BLOCK, v * BLOCK, depth[v, u] / 1000.0)
    body: Points = seen @ camera.body_from_camera.T + camera.position_body
    return body
