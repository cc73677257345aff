"""The avoidance systems by the name that the command line has for them."""

from __future__ import annotations

from collections.abc import Callable

from orchard_cli.avoidance import Blind, Dfa, Ego, Guided, Zones
from orchard_cli.errors import Fault, InputError
from orchard_cli.flight.ports import Avoidance
from orchard_cli.perception import DepthDetector, RgbdEyes


def _zones() -> Avoidance:
    """With eyes that need no weights."""
    return Zones(RgbdEyes(DepthDetector()))


SYSTEMS: dict[str, Callable[[], Avoidance]] = {
    "guided": Guided,
    "ego": Ego,
    "ego-published": Ego.published,
    "zones": _zones,
    "dfa": Dfa,
    "dfa-wide": Dfa.wide,
    "none": Blind,
}


def maker(system: str) -> Callable[[], Avoidance]:
    """What makes the system of that name. Raises InputError."""
    if system not in SYSTEMS:
        known = ", ".join(SYSTEMS)
        raise InputError(Fault("--system", f"no system {system!r}", f"choose of {known}"))
    return SYSTEMS[system]
