"""How much of the battery a flight takes, before it is flown.

The model is hover endurance: whatever a multirotor does at a few metres per second, it draws about
the power that holds it up, so a flight of t seconds takes t / endurance of the battery. Wind,
payload and age are in the endurance that the crew states; what the model leaves out is in the
reserve.
"""

from __future__ import annotations

from orchard_cli.model.arrays import Points
from orchard_cli.model.mission import Limits
from orchard_cli.model.site import Orchard

GROUND_TIME = 10.0  # s with turning rotors: arming, settling, turning the nose
LANDING_SPEED = 0.7  # m/s, PX4's MPC_LAND_SPEED


def share(airborne: float, height_up: float, height_down: float, limits: Limits) -> float:
    """Share of the battery from arming to landing.

    `airborne` is the trajectory's duration, s; the heights are climbed before and lost after it, m.
    """
    climb = height_up / limits.climb_speed
    descent = height_down / min(LANDING_SPEED, limits.climb_speed)
    return (GROUND_TIME + climb + airborne + descent) / limits.endurance


def share_over(orchard: Orchard, ends_site: Points, airborne: float, limits: Limits) -> float:
    """Share of the battery for a trajectory of `airborne` s whose ends are two places (2, 3) m."""
    up, down = (float(end[2]) - orchard.ground_near(end[:2]) for end in ends_site)
    return share(airborne, up, down, limits)
