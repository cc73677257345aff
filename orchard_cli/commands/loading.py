"""What the vehicle carries, and what that leaves of its limits."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.mission import Mission
from orchard_cli.model.tank import SPRAYER, Load

if TYPE_CHECKING:
    from .wiring import Choices

VEHICLES = ("x500", SPRAYER.name)


def vehicle_choice(name: str, level: float) -> tuple[str, float]:
    """A vehicle and the level of its tank. Raises InputError for a vehicle that there is not."""
    if name not in VEHICLES:
        known = " or ".join(VEHICLES)
        raise InputError(Fault("--vehicle", f"no vehicle {name!r}", f"choose {known}"))
    return name, level


def carried(mission: Mission, choices: Choices) -> Load | None:
    """The tank at take-off; None for a vehicle without one."""
    if choices.vehicle != SPRAYER.name:
        return None
    flow = None if mission.tank is None else mission.tank.flow
    vehicle = SPRAYER if flow is None else replace(SPRAYER, flow=60 * flow)
    return Load(vehicle, choices.level)


def loaded(mission: Mission, choices: Choices) -> Mission:
    """The mission with the limits that the vehicle can keep, and with stops where that was chosen.

    Raises InputError when the vehicle is too heavy for how the mission was timed.
    """
    if choices.stops:
        from orchard_cli.mission import with_stops

        mission = with_stops(mission)
    load = carried(mission, choices)
    if load is None:
        return mission
    limits = load.limits(mission.limits)
    if limits.acceleration < mission.limits.acceleration * (1 - 1e-9):
        able, planned = limits.acceleration, mission.limits.acceleration
        what = f"with this load {able:.2f} m/s² at most, and the mission asks for {planned:.2f}"
        raise InputError(Fault("--level", what, "fill in less, or plan with less acceleration"))
    return replace(mission, limits=limits)
