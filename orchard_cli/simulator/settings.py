"""How to run the simulator."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from .autopilot.battery import Pack
from .fleet import Kit


@dataclass(frozen=True, slots=True)
class SimulatorSettings:
    """Choices for a run. Frames and telemetry are stamped with the same simulated time."""

    seed: int | None = None  # overrides the world's
    speed_factor: float = 1.0  # simulated seconds per real second that the process tries to keep
    port: int = 14540  # UDP, where MAVSDK listens
    autopilot_port: int = 14580  # UDP, where the autopilot listens; 0: any
    camera: tuple[int, int] | None = (424, 240)  # px, a mode of the D455; None: no camera
    frame_rate: float = 15.0  # Hz
    sensors: frozenset[str] = frozenset()  # besides depth, of model/sensors.py SENSORS
    parameters: dict[str, float] = field(default_factory=dict)  # PX4's, changed from their defaults
    pack: Pack | None = None  # None: the vehicle's own
    kit: Kit = field(default_factory=Kit)  # the vehicle

    def __post_init__(self) -> None:
        if not 0 < self.speed_factor < math.inf:
            raise ValueError("speed_factor: not a positive number")
        if not 0 < self.frame_rate <= 90:
            raise ValueError("frame_rate: the D455 gives up to 90 Hz")
