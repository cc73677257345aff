"""The avoidance systems by the name that the command line has for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from orchard_cli.avoidance import Astar, Blind, Dfa, Ego, Guided, Zones
from orchard_cli.errors import Fault, InputError
from orchard_cli.flight.ports import Avoidance
from orchard_cli.perception import DepthDetector, OnnxDetector, RgbdEyes

if TYPE_CHECKING:
    from .wiring import Choices


def _zones() -> Avoidance:
    """With eyes that need no weights."""
    return Zones(RgbdEyes(DepthDetector()))


SYSTEMS: dict[str, Callable[[], Avoidance]] = {
    "guided": Guided,
    "ego": Ego,
    "ego-published": Ego.published,
    "zones": _zones,
    "astar": Astar,
    "dfa": Dfa,
    "dfa-wide": Dfa.wide,
    "none": Blind,
}


BENCH_ONLY: Mapping[str, str] = {
    "ego-published": "the airframe's centre passes obstacles at 0.1 m (docs/ego.md)",
    "dfa": "it has touched obstacles in simulation (docs/dfa.md)",
    "dfa-wide": "it has touched obstacles in simulation (docs/dfa.md)",
}
"""Systems for the simulator and the bench alone, and why no real vehicle flies them."""


def demand_airworthy(system: str) -> None:
    """Raises InputError for a system that no real vehicle may fly."""
    if system in BENCH_ONLY:
        what = f"{system} does not fly a real vehicle: {BENCH_ONLY[system]}"
        raise InputError(Fault("--system", what, "fly guided, or leave --connect out"))


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
