"""What is plugged into the flight loop, and what comes out of it."""

from __future__ import annotations

from dataclasses import dataclass

from orchard_cli.model.tank import Load
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.motion.yaw import STEADY, YawRule

from .helm import Errand
from .onboard import OnboardJob, OnboardResult
from .ports import Camera, Clock, Guard, Operator, Recorder, Sensors, Truth, Vehicle
from .reporter import Reporter
from .worker import Worker


@dataclass(frozen=True, slots=True)
class Gear:
    """Everything plugged into the loop."""

    vehicle: Vehicle
    camera: Camera
    worker: Worker[OnboardJob, OnboardResult]
    errands: Worker[Errand, Trajectory]
    clock: Clock
    recorder: Recorder
    reporter: Reporter
    operator: Operator
    guard: Guard
    truth: Truth | None = None
    sensors: Sensors | None = None
    load: Load | None = None  # the tank at take-off; None: no tank
    yaw_rule: YawRule = STEADY


@dataclass(frozen=True, slots=True)
class Ending:
    """How the flight ended."""

    as_planned: bool
    why: str
    trouble: bool = False  # it never armed, or what became of it is not known
