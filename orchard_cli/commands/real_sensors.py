"""The sensors of a real vehicle, or why it must not fly without them."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from orchard_cli.errors import LinkError
from orchard_cli.flight.ports import Camera, Sensors
from orchard_cli.model.sensors import Sensed

if TYPE_CHECKING:
    from orchard_cli.model.mission import Mission
    from orchard_cli.vehicle import MavsdkVehicle

    from .wiring import Choices

PASSED_ON = frozenset({"radar", "range"})  # by an autopilot; nothing else is
PATIENCE = 5.0  # s for the first scan of each
_SENT_AS = {"radar": "OBSTACLE_DISTANCE", "range": "DISTANCE_SENSOR of ids 1 to 4"}


def refuse_unknown(system: str, needs: frozenset[str]) -> None:
    """Raises LinkError when no vehicle can have what the system needs."""
    if "colour" in needs:
        raise LinkError(
            f"{system} would see by colour images, and of a RealSense only the depth is read: "
            "leave out --detector, zones then sees by depth alone; or fly guided"
        )
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


def realsense(choices: Choices, now: Callable[[], float]) -> Camera:
    """The depth camera on the vehicle. Raises LinkError when there is none that can be used."""
    from orchard_cli.perception import Mount, RealSense, RealSenseSettings

    width, height = choices.camera
    settings = RealSenseSettings(
        width, height,
        spatial="spatial" in choices.filters, fill_holes="holes" in choices.filters,
        serial=choices.serial,
    )  # fmt: skip
    mount = Mount(np.array(choices.mount[:3]), choices.mount[3])
    try:
        return RealSense(settings, mount, now)
    except LinkError as error:
        raise LinkError(
            f"{error}; without eyes no avoidance flies: "
            "use --system none where the route is known to be free"
        ) from None


def demand_safe_failsafes(mission: Mission, vehicle: MavsdkVehicle, mend: bool) -> None:
    """Raises LinkError where the autopilot's own failsafes are unsafe and shall not be mended."""
    unsafe = vehicle.unsafe_failsafes(mission.highest)
    if unsafe and not mend:
        listed = "\n".join(f"  {finding}" for finding in unsafe)
        raise LinkError(
            f"the autopilot's own failsafes are not safe here:\n{listed}\n"
            "set them, or let orchard do it with --mend-failsafes"
        )
    vehicle.mend_failsafes(unsafe)
