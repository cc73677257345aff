"""What a flight writes down. Each record is one message of one log topic.

The recorder is handed these nouns and also VehicleState, Setpoint, DepthFrame, SensorScan and
Trajectory as they are; flightlog knows the topic and the format of each.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from .arrays import Points, Vector
from .depth import DepthFrame
from .mission import Mission
from .sensors import SensorScan
from .trajectory import Trajectory
from .vehicle import Setpoint, VehicleState


class Severity(Enum):
    """Of a log line; the values are those of Foxglove's Log schema."""

    DEBUG = 1
    INFO = 2
    WARNING = 3
    ERROR = 4


@dataclass(frozen=True, slots=True)
class LogLine:
    """A sentence for a human: /log."""

    time: float
    severity: Severity
    text: str
    room: str = "flight"


@dataclass(frozen=True, slots=True)
class PlannerRecord:
    """One onboard cycle: what was decided and why, and how long each stage took: /planner."""

    time: float  # s, when the cycle ended
    frame_time: float  # s, stamp of the depth frame that it used
    decision: str  # "keep", "avoid", "stop", ...
    why: str
    blocked_at: float | None  # m of path ahead to the first conflict; None: free
    stages_ms: Mapping[str, float] = field(default_factory=dict)  # CPU-independent: wall time


@dataclass(frozen=True, slots=True)
class SafetyRecord:
    """The flight's state and the faults seen: /safety. Written on every change and at 1 Hz."""

    time: float
    phase: str
    action: str
    why: str
    faults: tuple[str, ...] = ()
    tracking: float | None = None  # m that the autopilot has lately strayed; None: not known


@dataclass(frozen=True, slots=True)
class SprayRecord:
    """Whether the pump is on: /spray."""

    time: float
    on: bool
    row: int | None
    why: str
    level: float | None = None  # of the tank, 1 is full; None: no tank
    used: float | None = None  # l sprayed since take-off


@dataclass(frozen=True, slots=True, eq=False)
class TruthRecord:
    """Where the simulated vehicle really was: /truth. Never written on a real flight."""

    time: float
    position_site: Vector  # (3,) m
    velocity_site: Vector  # (3,) m/s
    site_from_body: Vector  # (4,) w, x, y, z
    contact: str = ""  # what it has touched, such as "pole 2", from then on; empty: nothing


@dataclass(frozen=True, slots=True, eq=False)
class NewTrajectory:
    """A trajectory taken into flight, and its guide path: /trajectory, /guide_path."""

    time: float
    trajectory: Trajectory
    guide_site: Points  # (n, 3) m; empty when there was none
    why: str


@dataclass(frozen=True, slots=True, eq=False)
class OccupiedCells:
    """Centres of the occupied cells near the vehicle: /map/occupied."""

    time: float
    centres_site: Points  # (n, 3) m
    cell: float  # m


@dataclass(frozen=True, slots=True, eq=False)
class RunHeader:
    """Written once, before anything else: what flies, where, with what."""

    run_id: str
    system: str
    tool_version: str
    vehicle: str
    site: str
    simulated: bool
    seed: int | None
    utc_offset: float  # s: UTC (Unix) minus the flight clock
    mission: Mission
    attachments: Mapping[str, bytes] = field(default_factory=dict)  # name -> file, as flown


Record = (
    RunHeader
    | VehicleState
    | Setpoint
    | DepthFrame
    | SensorScan
    | LogLine
    | PlannerRecord
    | SafetyRecord
    | SprayRecord
    | TruthRecord
    | NewTrajectory
    | OccupiedCells
)
