"""What the pilot says of the depth camera on the command line."""

from __future__ import annotations

import math

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.depth import d455


def camera_mode(text: str) -> tuple[int, int]:
    """WIDTHxHEIGHT. Raises InputError for a mode that the camera has not."""
    try:
        width, height = (int(part) for part in text.split("x"))
        d455(width, height)
    except ValueError:
        modes = "848x480, 640x480, 424x240 or 212x120"
        raise InputError(Fault("--camera", f"no depth mode {text!r}", f"use {modes}")) from None
    return width, height


def camera_mount(text: str) -> tuple[float, float, float, float]:
    """FORWARD,LEFT,UP in m and the tilt DOWN in degrees, as m and rad. Raises InputError."""
    try:
        forward, left, up, down = (float(part) for part in text.split(","))
        if not (max(abs(forward), abs(left), abs(up)) < 5.0 and abs(down) < 60.0):
            raise ValueError("no such place on an airframe")
    except ValueError:
        mend = "write FORWARD,LEFT,UP in m (under 5) and DOWN in degrees (under 60), as 0.1,0,0,0"
        raise InputError(Fault("--camera-mount", f"no place {text!r}", mend)) from None
    return forward, left, up, math.radians(down)


def camera_filters(text: str) -> tuple[str, ...]:
    """Names of the vendor's filters. Raises InputError for one that is not known."""
    names = tuple(part.strip() for part in text.split(",") if part.strip())
    for name in names:
        if name not in ("spatial", "holes"):
            fault = Fault("--camera-filters", f"no filter {name!r}", "choose of spatial, holes")
            raise InputError(fault)
    return names
