"""The avoidance systems by the name that the command line has for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from orchard_cli.avoidance import Astar, Blind, Dfa, Ego, Guided, Zones
from orchard_cli.errors import Fault, InputError
from orchard_cli.flight.ports import Avoidance
from orchard_cli.motion.yaw import PUBLISHED, STEADY, YawRule
from orchard_cli.perception import DepthDetector, OnnxDetector, RgbdEyes
from orchard_cli.perception.radar_camera import RadarCamera

if TYPE_CHECKING:
    from .wiring import Choices


def _zones() -> Avoidance:
    """With eyes that need no weights."""
    return Zones(RgbdEyes(DepthDetector()))


def _fused() -> Avoidance:
    """With radar and colour camera besides the map. Raises InputError without OpenCV."""
    return Astar(fusion=RadarCamera())


FUSED = "astar-fused"
SYSTEMS: dict[str, Callable[[], Avoidance]] = {
    "guided": Guided,
    "ego": Ego,
    "ego-published": Ego.published,
    "zones": _zones,
    "astar": Astar,
    FUSED: _fused,
    "dfa": Dfa,
    "dfa-wide": Dfa.wide,
    "none": Blind,
}


def needs_of(system: str) -> frozenset[str]:
    """Its sensors besides depth, also where what it is made with is not installed."""
    return RadarCamera.needs if system == FUSED else SYSTEMS[system]().needs


BENCH_ONLY: Mapping[str, str] = {
    "ego-published": "the airframe's centre passes obstacles at 0.1 m (docs/ego.md)",
    "dfa": "it has touched obstacles in simulation (docs/dfa.md)",
    "dfa-wide": "it has touched obstacles in simulation (docs/dfa.md)",
}
"""Systems for the simulator and the bench alone, and why no real vehicle flies them."""


YAW_RULES: Mapping[str, YawRule] = {"steady": STEADY, "published": PUBLISHED}
"""By the name that --yaw takes: the flight loop's own, and EGO-Planner's."""


def demand_airworthy(system: str, yaw: str | None = None) -> None:
    """Raises InputError for a system, or a rule of the yaw, that no real vehicle may fly."""
    if system in BENCH_ONLY:
        what = f"{system} does not fly a real vehicle: {BENCH_ONLY[system]}"
        raise InputError(Fault("--system", what, "fly guided, or leave --connect out"))
    if yaw not in (None, "steady"):
        what = f"{yaw} turns faster than the mission allows, and in steps"
        raise InputError(Fault("--yaw", what, "leave it out, or leave --connect out"))


def yaw_rule(choices: Choices) -> YawRule:
    """How the nose is turned: as chosen, or as is the system's own. Raises InputError."""
    name = choices.yaw or ("published" if choices.system == "ego-published" else "steady")
    if name not in YAW_RULES:
        known = ", ".join(YAW_RULES)
        raise InputError(Fault("--yaw", f"no rule {name!r}", f"choose of {known}"))
    return YAW_RULES[name]


def maker(choices: Choices) -> Callable[[], Avoidance]:
    """What makes the system that was chosen. Raises InputError."""
    system = choices.system
    if system not in SYSTEMS:
        known = ", ".join(SYSTEMS)
        raise InputError(Fault("--system", f"no system {system!r}", f"choose of {known}"))
    if choices.detector is None:
        return SYSTEMS[system]
    if system != "zones":
        raise InputError(Fault("--detector", f"{system} has no use for it", "fly --system zones"))
    detector = OnnxDetector.load(choices.detector, choices.detector_names)
    return lambda: Zones(RgbdEyes(detector))
