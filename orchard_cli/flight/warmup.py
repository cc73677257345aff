"""Runs the onboard cycle once on made-up frames, so that nothing is compiled in flight."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.depth import DepthCamera, DepthFrame
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import FlightMode, Landed, Pose, VehicleState
from orchard_cli.motion.braking import brake, brake_within

from .eyesight import worth
from .onboard import Onboard, OnboardJob

FRAMES = 8
HEIGHT = 3.0  # m


def warm_up(onboard: Onboard, camera: DepthCamera) -> None:
    """Map a wall ahead and plan around it with a throw-away `onboard`."""
    depth = np.zeros((camera.height, camera.width), dtype=np.uint16)
    middle = camera.width // 2
    depth[:, middle - camera.width // 16 : middle + camera.width // 16] = 3500
    worth(depth)
    steps = np.arange(-2, 40) * 0.5
    line = np.stack([steps, np.zeros_like(steps), np.full_like(steps, HEIGHT)], axis=1)
    route = Trajectory(0.0, 0.5, line)
    for k in range(FRAMES):
        now = 1.0 + k / 15.0
        state = _hovering(now)
        poses = (Pose(now - 0.1, state.position_site, state.site_from_body), state.pose)
        frame = DepthFrame(now - 0.05, depth, camera)
        onboard.cycle(OnboardJob(now, now + 0.3, frame, poses, state, route, route))
    brake(route, 2.0, 0.5)  # every flight may have to, whatever avoids for it
    brake_within(route, 2.0, 1.0, 0.3, 0.5)


def _hovering(now: float) -> VehicleState:
    return VehicleState(
        time=now,
        position_site=np.array([now, 0.0, HEIGHT]),
        velocity_site=np.zeros(3),
        site_from_body=np.array([1.0, 0.0, 0.0, 0.0]),
        angular_velocity_body=np.zeros(3),
        armed=True,
        mode=FlightMode.OFFBOARD,
        landed=Landed.IN_AIR,
        heard=now,
        battery_share=1.0,
        battery_voltage=16.0,
        ready=True,
    )
