"""The depth camera, as its vendor's library sees it."""

from __future__ import annotations

from orchard_cli.errors import LinkError
from orchard_cli.perception import find

from .finding import Finding, Verdict, judged


def camera(wanted: bool) -> list[Finding]:
    """Each RealSense that is plugged in. `wanted`: a real flight is meant, which needs one."""
    missing = Verdict.BAD if wanted else Verdict.NOTE
    try:
        found = find()
    except LinkError as error:
        return [Finding("camera", "RealSense", "not usable", missing, str(error))]
    if not found:
        mend = "plug it in; without one only --system none flies on a real vehicle"
        return [Finding("camera", "RealSense", "none is plugged in", missing, mend)]
    return [
        judged(
            "camera", f"{one.name} {one.serial}", f"firmware {one.firmware}, USB {one.usb}",
            one.usb.startswith("3"), "plug it into a USB 3 port: USB 2 has not all depth modes",
        )
        for one in found
    ]  # fmt: skip
