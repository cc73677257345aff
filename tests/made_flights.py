"""Made-up missions and flights whose metrics are known beforehand. Not flown, not simulated."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from orchard_cli.model.arrays import Points
from orchard_cli.model.depth import DepthFrame, d455
from orchard_cli.model.mission import Leg, Limits, Mission, Provenance, Segment
from orchard_cli.model.records import (
    LogLine,
    NewTrajectory,
    OccupiedCells,
    PlannerRecord,
    Record,
    RunHeader,
    SafetyRecord,
    Severity,
    SprayRecord,
    TruthRecord,
)
from orchard_cli.model.site import HeightReference, KnownObstacle, Orchard, SiteOrigin, TreeRow
from orchard_cli.model.trajectory import BSpline, Trajectory
from orchard_cli.model.vehicle import FlightMode, Landed, Setpoint, VehicleState

UTC_OFFSET = 1_700_000_000.25
SPEED = 1.0  # m/s
HEIGHT = 3.5  # m
ROW_LENGTH = 20.0  # m
ROW_GAP = 6.0  # m


def corners(rows: int = 2) -> Points:
    """The Π's corners: along +x, across, back along -x, ..."""
    points = []
    for row in range(rows):
        ends = (0.0, ROW_LENGTH) if row % 2 == 0 else (ROW_LENGTH, 0.0)
        points += [[x, row * ROW_GAP, HEIGHT] for x in ends]
    return np.array(points)


def along(polyline: Points, distances: np.ndarray) -> Points:
    """Points at path lengths along a polyline: (n,) m -> (n, 3)."""
    steps = np.linalg.norm(np.diff(polyline, axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(steps)])
    return np.column_stack([np.interp(distances, at, polyline[:, i]) for i in range(3)])


def length(polyline: Points) -> float:
    return float(np.linalg.norm(np.diff(polyline, axis=0), axis=1).sum())


def mission(rows: int = 2) -> Mission:
    """A Π over straight rows, flown at constant speed; curve and Π agree but for the corners."""
    waypoints = corners(rows)
    total = length(waypoints)
    samples = along(waypoints, np.linspace(0.0, total, int(total * 2) + 1))
    control = np.vstack(
        [samples[:1] - (samples[1] - samples[0]), samples, 2 * samples[-1:] - samples[-2:-1]]
    )
    interval = total / (len(samples) - 1) / SPEED
    n = len(samples)
    knots = np.concatenate([[0.0] * 3, np.linspace(0.0, total, n - 2), [total] * 3])
    orchard = Orchard(
        name="made-up",
        origin=SiteOrigin(23.1, 113.3, 12.0, HeightReference.ELLIPSOID, 0.3),
        rows=tuple(
            TreeRow(
                np.column_stack([np.arange(0.0, ROW_LENGTH + 1, 4.0), np.full(6, row * ROW_GAP)]),
                np.zeros(6),
                np.full(6, 2.6),
            )
            for row in range(rows)
        ),
        obstacles=(KnownObstacle(np.array([10.0, 1.5]), 0.15, 6.0),),
    )
    return Mission(
        name="made-up",
        orchard=orchard,
        waypoints_site=waypoints,
        waypoints_wgs84=waypoints * 0 + [23.1, 113.3, 15.5],
        route_length=total,
        corner_cut=0.3,
        spline=BSpline(3, knots, samples),
        trajectory=Trajectory(0.0, interval, control),
        segments=(Segment(Leg.ROW, 0.0, total / SPEED, 0, 2 * rows - 1),),
        takeoff_site=waypoints[0, :2],
        landing_site=waypoints[-1, :2],
        limits=Limits(),
        swath=4.0,
        energy_share=0.4,
        provenance=Provenance("made-up.toml", "0" * 64, "0", "2026-01-01T00:00:00Z"),
    )


@lru_cache
def planned_mission(rows: int = 2) -> Mission:
    """The same orchard with a mission that passes every check."""
    from orchard_cli.mission import plan
    from orchard_cli.model.wishes import FlightWishes

    made = mission(rows)
    return plan(made.orchard, FlightWishes(height=HEIGHT), made.provenance)


def no_detour(positions: Points) -> Points:
    """Fly the Π as it stands."""
    return positions


@dataclass(frozen=True)
class Bump:
    """Go `peak` metres to the left of row 0 around x = `centre`, over `width` metres, smoothly."""

    centre: float = 10.0
    width: float = 6.0
    peak: float = 1.5
    drop: float = 0.0  # m of height lost at the peak

    def __call__(self, positions: Points) -> Points:
        phase = np.clip((positions[:, 0] - self.centre) / self.width, -0.5, 0.5)
        bell = 0.5 * (1 + np.cos(2 * np.pi * phase)) * (positions[:, 1] < ROW_GAP / 2 - 1e-9)
        moved = positions.copy()
        moved[:, 1] += self.peak * bell
        moved[:, 2] -= self.drop * bell
        return moved


def header(plan: Mission, attachments: dict[str, bytes] | None = None) -> RunHeader:
    return RunHeader(
        run_id="run-1",
        system="guided",
        tool_version="0.0.0",
        vehicle="made-up",
        site="made-up",
        simulated=True,
        seed=7,
        utc_offset=UTC_OFFSET,
        mission=plan,
        attachments={} if attachments is None else attachments,
    )


def state(time: float, position: Points, velocity: Points, yaw: float = 0.0, yaw_rate: float = 0.0,
          battery: float = 0.9) -> VehicleState:  # fmt: skip
    return VehicleState(
        time=time,
        position_site=position,
        velocity_site=velocity,
        site_from_body=np.array([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)]),
        angular_velocity_body=np.array([0.0, 0.0, yaw_rate]),
        armed=True,
        mode=FlightMode.OFFBOARD,
        landed=Landed.IN_AIR,
        heard=time,
        battery_share=battery,
        battery_voltage=float("nan"),
        ready=True,
    )


def flight(
    plan: Mission,
    detour: Callable[[Points], Points] = no_detour,
    rate: float = 30.0,
    depth: bool = False,
    attachments: dict[str, bytes] | None = None,
    start: float = 100.0,
    as_planned: bool = False,
) -> Iterator[Record]:
    """A flight with a detour; truth is the odometry.

    Along the Π at constant progress; `as_planned`: along the mission's own trajectory.
    """
    total = plan.trajectory.end if as_planned else plan.route_length / SPEED
    times = np.arange(0.0, total + 0.5 / rate, 1.0 / rate)
    if as_planned:
        positions = detour(plan.trajectory.sample(times)[0])
    else:
        positions = detour(along(plan.waypoints_site, times * SPEED))
    velocities = np.gradient(positions, 1.0 / rate, axis=0)
    accelerations = np.gradient(velocities, 1.0 / rate, axis=0)
    yaws = np.unwrap(np.arctan2(velocities[:, 1], velocities[:, 0]))
    rates = np.gradient(yaws, 1.0 / rate)
    camera = d455(212, 120)
    yield header(plan, attachments)
    yield LogLine(start, Severity.INFO, "made-up flight")
    yield NewTrajectory(start, plan.trajectory.shifted(start), np.empty((0, 3)), "the mission")
    yield SprayRecord(start, True, 0, "on the row")
    for i, t in enumerate(times):
        now = start + float(t)
        share = 0.9 - 0.4 * float(t) / total
        yield state(now, positions[i], velocities[i], float(yaws[i]), float(rates[i]), share)
        q = np.array([np.cos(yaws[i] / 2), 0.0, 0.0, np.sin(yaws[i] / 2)])
        yield TruthRecord(now, positions[i], velocities[i], q)
        yield Setpoint(now, positions[i], velocities[i], accelerations[i], float(yaws[i]))
        if i % 3 == 0:
            yield PlannerRecord(now, now - 0.05, "keep", "free", None, {"map": 3.0, "check": 1.0})
        if i % 30 == 0:
            yield SafetyRecord(now, "flying", "follow", "all well")
        if depth and i % 10 == 0:
            image = np.full((120, 212), 2000 + i, np.uint16)
            yield DepthFrame(now, image, camera)
            yield OccupiedCells(now, np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]), 0.1)
    yield SprayRecord(start + float(times[-1]), False, None, "end of the row")
