"""What the pilot's screen tells."""

from __future__ import annotations

from dataclasses import dataclass

from .safety import Phase


@dataclass(frozen=True, slots=True)
class Status:
    """One picture of the flight; NaN where something is not known."""

    time: float  # s since the flight loop began
    phase: Phase
    why: str
    mode: str
    height: float  # m above the take-off ground
    speed: float  # m/s
    cross_track: float  # m from the Π
    progress: float  # 0 to 1 of the trajectory
    remaining: float  # s to its end
    battery: float  # 0 to 1
    frame_age: float  # s
    silence: float  # s
    cycle_ms: float  # of the newest onboard cycle
    decision: str  # newest verdict, in words
    avoidances: int
    spraying: bool
    hazards: tuple[str, ...]
