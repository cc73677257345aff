"""The sensors of a real vehicle besides the camera, or why it must not fly without them."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from orchard_cli.errors import LinkError
from orchard_cli.flight.ports import Sensors
from orchard_cli.model.sensors import Sensed

if TYPE_CHECKING:
    from orchard_cli.vehicle import MavsdkVehicle

PASSED_ON = frozenset({"radar", "range"})  # by an autopilot; nothing else is
PATIENCE = 5.0  # s for the first scan of each
_SENT_AS = {"radar": "OBSTACLE_DISTANCE", "range": "DISTANCE_SENSOR of ids 1 to 4"}


def refuse_unknown(system: str, needs: frozenset[str]) -> None:
    """Raises LinkError when no vehicle can have what the system needs."""
    if needs - PASSED_ON:
        raise LinkError(
            f"{system} needs {' and '.join(sorted(needs - PASSED_ON))}, which are not connected; "
            "choose a system that flies by depth alone, such as guided"
        )


def await_sensors(
    system: str, needs: frozenset[str], vehicle: MavsdkVehicle, arm: float
) -> Sensors | None:
    """Listen until each has spoken; None when none is needed. Raises LinkError when one is silent.

    `arm`: m from the body's centre to the radar, and to the lasers along x and along y.
    """
    if not needs:
        return None
    found = vehicle.rangefinders(arm)
    until = time.monotonic() + PATIENCE
    while missing := _missing(needs, found.newest()):
        if time.monotonic() > until:
            heard = ", ".join(f"{name} ({_SENT_AS[name]})" for name in sorted(missing))
            raise LinkError(
                f"{system} needs what the autopilot does not send: {heard}; "
                "connect it, or choose a system that flies by depth alone, such as guided"
            )
        time.sleep(0.1)
    return found


def _missing(needs: frozenset[str], sensed: Sensed) -> frozenset[str]:
    spoken = {"radar": sensed.radar, "range": sensed.range}
    return frozenset(name for name in needs if spoken[name] is None)
