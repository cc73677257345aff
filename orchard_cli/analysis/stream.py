"""Two things a flight is held to: every waypoint passed, and setpoints at an even pace."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Array
from orchard_cli.model.flown import Track
from orchard_cli.model.mission import WAYPOINT_PASSED, Mission

from .figures import Figure, Unknown

PERIOD = 0.02  # s between setpoints: 50 Hz
PAUSE = 0.5  # s: more than that is another stream, not jitter


def waypoints_missed(track: Track, mission: Mission) -> int:
    """How many waypoints the flown route (its track) passed at more than WAYPOINT_PASSED m."""
    places = track.positions_site[:, :2]
    return sum(
        float(np.hypot(*(places - waypoint[:2]).T).min(initial=np.inf)) > WAYPOINT_PASSED
        for waypoint in mission.waypoints_site
    )


def setpoint_jitter(times: Array) -> Figure:
    """ms: 99th percentile of |interval - PERIOD| between setpoints (n,) s of one stream."""
    apart = np.diff(times)
    apart = apart[apart < PAUSE]
    if len(apart) < 100:
        return Unknown("the log holds too few setpoints")
    return float(np.quantile(np.abs(apart - PERIOD), 0.99)) * 1e3
