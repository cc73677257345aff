"""Depth frames to measure on: drawn along a mission, or taken from a flight's log."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.geometry.poses import interpolate
from orchard_cli.model.depth import DepthCamera, DepthFrame, d455
from orchard_cli.model.mission import Mission
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import FlightMode, Landed, Pose, VehicleState
from orchard_cli.model.world import World
from orchard_cli.motion.yaw import heading_ahead
from orchard_cli.simulator.scene import Scene

from .samples import Samples

RATE = 15.0  # Hz
LOOK_AHEAD = 0.8  # s: the nose points to where the vehicle will be then
STOP_SHORT = 2.0  # s before a pole at which a stretch ends: the line leads through the pole
LOW = 1.5  # m above the ground
BETWEEN_ROWS = 3.0  # m beside the row
EGO_STRIDE = 2  # px
EGO_RANGE = 4.5  # m


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """One frame, and the vehicle when it was taken."""

    frame: DepthFrame
    vehicle: VehicleState


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """Frames that follow each other, and what was being flown."""

    seen: tuple[Seen, ...]
    route: Trajectory | None  # on the frames' clock; None: not known


def drawn(
    mission: Mission, world: World, count: int, samples: Samples, low: bool = False
) -> tuple[Stretch, ...]:
    """About `count` frames, 848x480, in a stretch before each pole that stands on the route.

    `low`: not as flown, over the trees, but between the rows, where every second pixel returns
    from within range instead of every ninth. The same arguments give the same frames. Times the
    drawing as `render`.
    """
    scene, camera = Scene(world), d455()
    ends = approaches(mission.trajectory, world)
    route = _lowered(mission.trajectory) if low else mission.trajectory
    each = max(count // len(ends), 2)
    stretches = []
    for end in ends:
        times = end - (each - 1 - np.arange(each)) / RATE
        scene.render(camera, *_pose(route, times[0]), times[0], 0)  # compile
        seen = []
        for number, time in enumerate(times.tolist()):
            position, attitude = _pose(route, time)
            with samples.timed("render"):
                depth = scene.render(camera, position, attitude, time, number)
            velocity = route.at(time).velocity_site
            vehicle = in_flight(Pose(time, position, attitude), velocity)
            seen.append(Seen(DepthFrame(time, depth, camera), vehicle))
        stretches.append(Stretch(tuple(seen), route))
    return tuple(stretches)


def _lowered(route: Trajectory) -> Trajectory:
    moved = route.control_points_site + np.array([0.0, BETWEEN_ROWS, 0.0])
    moved[:, 2] = LOW
    return Trajectory(route.start, route.interval, moved)


def approaches(route: Trajectory, world: World) -> tuple[float, ...]:
    """Times at which a route is STOP_SHORT of a pole that it leads through; else its middle."""
    times = np.arange(route.start, route.end, 0.1)
    path = route.sample(times)[0]
    found = []
    for pole in world.poles:
        away = np.hypot(path[:, 0] - pole.x, path[:, 1] - pole.y)
        nearest = int(np.argmin(away))
        if away[nearest] < pole.radius:
            found.append(float(times[nearest]) - STOP_SHORT)
    return tuple(sorted(found)) or (float(times[len(times) // 2]),)


def _pose(route: Trajectory, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Position and attitude, level, the nose along the route."""
    yaw = heading_ahead(route, time, LOOK_AHEAD) or 0.0
    attitude = np.array([math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)])
    return route.at(time).position_site, attitude


def in_flight(pose: Pose, velocity_site: np.ndarray) -> VehicleState:
    """An armed vehicle under offboard control."""
    return VehicleState(
        time=pose.time,
        position_site=pose.position_site,
        velocity_site=velocity_site,
        site_from_body=pose.site_from_body,
        angular_velocity_body=np.zeros(3),
        armed=True,
        mode=FlightMode.OFFBOARD,
        landed=Landed.IN_AIR,
        heard=pose.time,
        battery_share=1.0,
        battery_voltage=16.0,
        ready=True,
    )


def recorded(log: Path) -> tuple[Stretch, ...]:
    """The depth frames of a log, each with its pose, and the first trajectory that it tells of.

    Raises InputError when it holds no frames.
    """
    from orchard_cli.flightlog import read
    from orchard_cli.flightlog.frames import depth_frames

    flown = read(log)
    track = flown.odometry
    poses = [
        Pose(float(t), p, q)
        for t, p, q in zip(track.times, track.positions_site, track.site_from_body, strict=True)
    ]
    seen = []
    for frame in depth_frames(log):
        pose = interpolate(poses, frame.time)
        if pose is not None and frame.depth_mm.any():
            velocity = track.velocities_site[int(np.searchsorted(track.times, frame.time)) - 1]
            seen.append(Seen(frame, in_flight(pose, velocity)))
    if not seen:
        raise InputError(Fault(str(log), "holds no depth frames", "name a log of a whole flight"))
    route = flown.trajectories[0].trajectory if flown.trajectories else None
    return (Stretch(tuple(seen), route),)


def thinned(stretches: Sequence[Stretch]) -> tuple[Stretch, ...]:
    """The frames as EGO-Planner's map takes them: every second pixel, up to 4.5 m."""
    return tuple(Stretch(tuple(map(_thinned, one.seen)), one.route) for one in stretches)


def _thinned(seen: Seen) -> Seen:
    old = seen.frame.camera
    depth = np.ascontiguousarray(seen.frame.depth_mm[::EGO_STRIDE, ::EGO_STRIDE])
    camera: DepthCamera = dataclasses.replace(
        old,
        width=depth.shape[1],
        height=depth.shape[0],
        fx=old.fx / EGO_STRIDE,
        fy=old.fy / EGO_STRIDE,
        cx=old.cx / EGO_STRIDE,  # pixel (u, v) is the old (2 u, 2 v)
        cy=old.cy / EGO_STRIDE,
        range_max=min(old.range_max, EGO_RANGE),
    )
    return Seen(DepthFrame(seen.frame.time, depth, camera), seen.vehicle)
