"""Rules about how the vehicle moves."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.mission import Limits

from .flown import Flown
from .report import Finding, Rule, Sense, judge_along, judge_total

SHARE = 0.01  # by which the spline may exceed a limit: it only approximates its time law
_STILL = 0.01  # m/s


def motion_findings(flown: Flown, limits: Limits) -> list[Finding]:
    """Speed, acceleration, yaw rate and curvature, moment by moment; rest at both ends."""
    tables = (
        ("speed", flown.speeds, limits.speed, "m/s"),
        ("climb and sink", np.abs(flown.velocities[:, 2]), limits.climb_speed, "m/s"),
        (
            "acceleration",
            np.linalg.norm(flown.accelerations, axis=1),
            limits.acceleration,
            "m/s²",
        ),
        (
            "acceleration along the path",
            flown.accelerations_along,
            limits.acceleration_along,
            "m/s²",
        ),
        ("yaw rate", flown.yaw_rates, limits.yaw_rate, "rad/s"),
    )
    findings = []
    for name, figures, limit, unit in tables:
        rule = Rule(name, Sense.AT_MOST, limit, unit, SHARE * limit)
        findings += judge_along(rule, flown, figures)
    return [*findings, *_curvature(flown, limits), *_rest(flown)]


def _curvature(flown: Flown, limits: Limits) -> list[Finding]:
    """The bend against the tightest one that acceleration and yaw rate allow at its speed.

    The nose turns with the bend as it is seen from above: into a climb it need not turn at all.
    """
    by_acceleration = flown.curvatures * flown.speeds**2 / limits.acceleration
    share = np.maximum(by_acceleration, flown.yaw_rates / limits.yaw_rate)
    worst = int(share.argmax())
    radius = math.inf if flown.curvatures[worst] == 0 else 1 / flown.curvatures[worst]
    rule = Rule("curvature at its speed", Sense.AT_MOST, 1.0, "of what is allowed", 2 * SHARE)
    about = f"radius {radius:.2f} m at {flown.speeds[worst]:.2f} m/s"
    return judge_along(rule, flown, share, about)


def _rest(flown: Flown) -> list[Finding]:
    rule = Rule("at rest at both ends", Sense.AT_MOST, _STILL, "m/s")
    return judge_total(rule, float(max(flown.speeds[0], flown.speeds[-1])))
