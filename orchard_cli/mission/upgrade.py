"""Mission files of older versions, brought up to this one."""

from __future__ import annotations

from typing import Any


def upgraded(document: dict[str, Any]) -> dict[str, Any]:
    """A document of version 1 as one of version 2; whatever is wrong in it stays wrong.

    Version 1 had one waypoint at each end of each row, so each segment between the two transits
    ends at the next waypoint; version 2 says so (`until`).
    """
    segments = document.get("segments")
    if not isinstance(segments, list) or not all(isinstance(s, dict) for s in segments):
        return {**document, "version": 2}
    reached = 0
    told = []
    for segment in segments:
        reached += segment.get("leg") != "transit"
        told.append({**segment, "until": reached})
    return {**document, "version": 2, "segments": told}
