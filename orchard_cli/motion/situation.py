"""The avoidance interface's nouns: what a system is told, and its answer.

A system fits the socket `Avoidance` in flight/ports.py: `plan(situation) -> Verdict`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from orchard_cli.geometry.area import Area
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.model.arrays import Points
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.mission import Limits
from orchard_cli.model.sensors import Sensed
from orchard_cli.model.tank import Load
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import Pose, VehicleState


@dataclass(frozen=True, slots=True, eq=False)
class Situation:
    """Everything that a system may decide by, at one instant."""

    now: float  # s, flight clock
    commit: float  # s: the active trajectory is fixed up to here, a change may begin after it
    vehicle: VehicleState
    active: Trajectory  # being flown
    reference: Trajectory  # the mission's own, on the flight clock, without any avoidance
    grid: OccupancyGrid
    frame: DepthFrame  # newest
    limits: Limits
    area: Area | None = None  # where flying is allowed; what leaves it is refused; None: anywhere
    frame_pose: Pose | None = None  # the body's at the frame's time; None: not known
    load: Load | None = None  # of the vehicle's tank; `limits` are for it
    sensed: Sensed = field(default_factory=Sensed)  # newest scans of the sensors in `needs`


@dataclass(frozen=True, slots=True)
class Keep:
    """The active trajectory is free as far as is seen."""

    why: str = "free"
    blocked_at: float | None = None
    stages_ms: Mapping[str, float] = field(default_factory=dict)
    alarm: str = ""  # what the pilot must hear at once
    alive: bool = False  # a person or a drone is ahead, too near to fly on


@dataclass(frozen=True, slots=True, eq=False)
class Avoid:
    """Fly this instead. It equals the active trajectory up to `Situation.commit`."""

    trajectory: Trajectory
    begin: float  # s, where it leaves the active trajectory
    rejoin: float  # s, where it is back on the reference
    why: str
    blocked_at: float  # m along the path to the first conflict
    guide_site: Points = field(default_factory=lambda: np.empty((0, 3)))
    yaw_site: float | None = None  # rad, to look there until the rejoin; None: along the way
    stages_ms: Mapping[str, float] = field(default_factory=dict)
    alarm: str = ""  # what the pilot must hear at once
    alive: bool = False  # a person or a drone is ahead, too near to fly on


@dataclass(frozen=True, slots=True, eq=False)
class Stop:
    """No way round was found: fly this trajectory, which brakes to rest in seen, free space."""

    trajectory: Trajectory
    why: str
    blocked_at: float
    stages_ms: Mapping[str, float] = field(default_factory=dict)
    alarm: str = ""  # what the pilot must hear at once
    alive: bool = False  # a person or a drone is ahead, too near to fly on


Verdict = Keep | Avoid | Stop
