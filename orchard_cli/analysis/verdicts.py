"""What a flight is held to: each verdict with its rule, its limit and the figure found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from orchard_cli.model.mission import WAYPOINT_PASSED, Mission
from orchard_cli.motion.timing import TOLERANCE

from .figures import Metrics, Unknown

TRACKING = 1.3
"""A vehicle overshoots its plan: flown speeds and rates may be this many times the limit.

Liu 2024 flew 1.279 m/s at a limit of 1 m/s (§5.2).
"""


@dataclass(frozen=True, slots=True)
class Verdict:
    """One rule applied. `kept` is None when the figure is not known."""

    metric: str
    rule: str
    limit: float
    found: float | Unknown
    kept: bool | None
    found_text: str = ""  # what was found, where the figure alone says too little


def verdicts(metrics: Metrics, mission: Mission) -> tuple[Verdict, ...]:
    """Every rule, by the mission's own limits."""
    limits = mission.limits
    above: Callable[[float, float], bool] = lambda found, limit: found >= limit  # noqa: E731
    below: Callable[[float, float], bool] = lambda found, limit: found <= limit  # noqa: E731
    rules = (
        ("contacts", "nothing is touched in the air", 0, below),
        ("clearance_min_m", "obstacles are passed no nearer than the mission's clearance",
         limits.clearance, above),
        ("clearance_trees_min_m", "no tree is touched: farther than the airframe's radius",
         limits.airframe_radius, above),
        ("speed_max_m_s", f"speed stays under {TRACKING} times the mission's",
         TRACKING * limits.speed, below),
        ("acceleration_planned_max_m_s2",
         "no command asks for more than the mission's limit, "
         f"within the time law's tolerance of {TOLERANCE:.0%}",
         (1 + TOLERANCE) * limits.acceleration, below),
        ("yaw_rate_max_rad_s", f"yaw rate stays under {TRACKING} times the mission's",
         TRACKING * limits.yaw_rate, below),
        ("waypoints_missed", f"every waypoint is passed within {WAYPOINT_PASSED:g} m", 0, below),
        ("battery_left_percent", "the battery's reserve is left at the end",
         100.0 * limits.reserve, above),
    )  # fmt: skip
    return tuple(
        Verdict(
            name,
            rule,
            limit,
            found,
            None if isinstance(found, Unknown) else test(found, limit),
            ", ".join(map(str, metrics.contacts)) if name == "contacts" else "",
        )
        for name, rule, limit, test in rules
        for found in (metrics.figures[name],)
    )
