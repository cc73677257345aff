"""What can be made to go wrong in a running simulation, to see what the flight does.

`SimulatorProcess.inject(fault)` (or `LockstepSimulator.inject`, `Run.inject`) makes it happen. What
lasts for `seconds` (simulated; infinite: for good) ends by itself; the newest fault of a kind
replaces an older one, so `CameraFault(Failure.NONE)` mends the camera at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from orchard_cli.model.world import Pole

Triple = tuple[float, float, float]


class Failure(Enum):
    """How a depth camera fails while it goes on sending frames, with fresh time stamps."""

    NONE = "none"  # it is well again
    FROZEN = "frozen"  # the last good image again and again
    BLANK = "blank"  # zeros: no pixel has a return
    GARBAGE = "garbage"  # each pixel at random, over all that 16 bits can say
    SILENT = "silent"  # no frame at all


@dataclass(frozen=True, slots=True)
class CameraFault:
    """The depth camera fails."""

    failure: Failure
    seconds: float = math.inf


@dataclass(frozen=True, slots=True)
class GpsLoss:
    """The autopilot has no GPS fix: it says so and will not arm; its estimate goes on as before."""

    seconds: float = math.inf


@dataclass(frozen=True, slots=True)
class WindChange:
    """From now on the mean wind is this; gusts come on top as before."""

    velocity_site: Triple  # m/s, towards where the air moves


@dataclass(frozen=True, slots=True)
class BatteryDrop:
    """The battery holds no more than this from now on, as with a dying cell."""

    share: float  # 0 to 1


@dataclass(frozen=True, slots=True)
class ClockStep:
    """The autopilot's clock steps: all that it stamps is later by this from now on, s."""

    seconds: float


@dataclass(frozen=True, slots=True)
class EstimateJump:
    """The autopilot's estimator is reset: it believes to be elsewhere, from now on."""

    moved_site: Triple = (0.0, 0.0, 0.0)  # m
    turned: float = 0.0  # rad, of its heading


@dataclass(frozen=True, slots=True)
class OriginMove:
    """The autopilot's local origin is put elsewhere; what it believes on earth stays."""

    moved_site: Triple  # m


@dataclass(frozen=True, slots=True)
class Appearance:
    """Something stands in the world from now on, where nothing stood: seen, and hit."""

    pole: Pole


LinkFault = OriginMove | ClockStep
"""Those that exist only where there is MAVLink: not in lockstep."""

SimulatedFault = (
    CameraFault | GpsLoss | WindChange | BatteryDrop | EstimateJump | Appearance | LinkFault
)
