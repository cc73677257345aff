"""An orchard that one battery or one tank does not do: several flights, cut at row ends.

Each flight starts and ends at the one take-off point.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.arrays import Vector
from orchard_cli.model.mission import Mission, Provenance, Sortie
from orchard_cli.model.site import Orchard
from orchard_cli.model.wishes import FlightWishes

from . import route as routes
from .planner import plan, plan_passes

STORES = {"battery", "tank"}  # what several flights are a mend for
MOST = 100  # flights


def plan_sorties(
    orchard: Orchard, wishes: FlightWishes, provenance: Provenance
) -> tuple[Mission, ...]:
    """One mission where that is enough; else as few as a greedy cut at row ends gives.

    Raises InputError with every fault when the orchard cannot be flown safely.
    """
    try:
        return (plan(orchard, wishes, provenance),)
    except InputError as error:
        if not _stores_alone(error):
            raise
    return plan_from_home(orchard, wishes, provenance, routes.passes(orchard, wishes))


def plan_from_home(
    orchard: Orchard, wishes: FlightWishes, provenance: Provenance, flown: list[routes.Pass]
) -> tuple[Mission, ...]:
    """Fly these passes from and to the take-off point, in as many flights as it takes."""
    home = take_off(orchard, wishes)
    there = replace(wishes, takeoff_site=home, landing_site=home)
    missions: list[Mission] = []
    left, size = list(flown), len(flown)
    while left:
        if len(missions) == MOST:
            raise InputError(Fault("sorties", f"it takes more than {MOST}", "split the survey"))
        mission, size = _largest(orchard, there, provenance, left, size)
        missions.append(mission)
        left = left[size:]
    if len(missions) == 1:
        return (missions[0],)
    return tuple(
        replace(mission, sortie=Sortie(k, len(missions))) for k, mission in enumerate(missions, 1)
    )


def take_off(orchard: Orchard, wishes: FlightWishes) -> Vector:
    """(2,) m: the wished place, else the one where a flight over the whole orchard begins."""
    if wishes.takeoff_site is not None:
        return wishes.takeoff_site
    first = routes.passes(orchard, wishes)[0].points_site
    return np.round(routes.run_up_point(first[0], first[1], wishes.limits)[:2], 6)


def _largest(
    orchard: Orchard,
    wishes: FlightWishes,
    provenance: Provenance,
    left: list[routes.Pass],
    guess: int,
) -> tuple[Mission, int]:
    """The mission over the most of the next passes that fits, and how many that are.

    It begins at the size of the flight before and goes up or down from there.
    """
    best: tuple[Mission, int] | None = None
    size, growing = min(guess, len(left)), True
    while True:
        try:
            mission = plan_passes(orchard, wishes, provenance, left[:size])
        except InputError as error:
            if best is not None:
                return best
            if not _stores_alone(error) or size == 1:
                raise _told(error, left[0]) from error
            size, growing = min(size - 1, _fitting(wishes, left, size)), False
            continue
        best = mission, size
        if not growing or size == len(left) or not _may_fit(wishes, mission, left[: size + 1]):
            return best
        size += 1


def _fitting(wishes: FlightWishes, left: list[routes.Pass], size: int) -> int:
    """How many passes may fit, by their lengths alone: an upper bound, at least 1."""
    seconds = np.cumsum([one.length for one in left[:size]]) / wishes.limits.speed
    fits = seconds <= (1 - wishes.limits.reserve) * wishes.limits.endurance
    if wishes.tank is not None:
        litres = [
            wishes.tank.litres(float(s), float(s) * wishes.limits.speed, wishes.swath)
            for s in seconds
        ]
        fits &= np.array(litres) <= wishes.tank.capacity
    return max(1, int(fits.sum()))


def _may_fit(wishes: FlightWishes, mission: Mission, longer: list[routes.Pass]) -> bool:
    """Whether one more pass is worth a try: by its length alone it would fit."""
    more = longer[-1].length / wishes.limits.speed
    share = mission.energy_share + more / wishes.limits.endurance
    count = len(longer)
    return share <= 1 - wishes.limits.reserve and _fitting(wishes, longer, count) == count


def _stores_alone(error: InputError) -> bool:
    return all(fault.where in STORES for fault in error.faults)


def _told(error: InputError, first: routes.Pass) -> InputError:
    """A row that is too long by itself is named."""
    if not _stores_alone(error):
        return error
    return InputError(
        Fault(f"row {first.row + 1}: {fault.where}", fault.what, "this row alone is too much")
        for fault in error.faults
    )
