"""One avoidance: where it began, which way is forward, and when it may turn."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.motion.situation import Situation

from .numbers import ALPHA, AutomatonSettings, arm, safe_distance, trigger_time
from .states import NOTHING, S1, S3, Memory, Numbers, Reading, State
from .view import View

MARGIN = 0.15  # m beside the safe distance in which things count: what the radar is worth
MOVING = 0.2  # m/s above which the flight's direction is forward; the nose's below


@dataclass(slots=True, eq=False)
class Manoeuvre:
    """From the slowing down to the way back."""

    facing: Vector  # (2,) unit: forward, along the route where it began
    slope: float  # m up per m forward
    began: Vector  # (3,) m
    onto: float  # s on the reference's clock, where it began
    obstacle: Vector  # (3,) m, its nearest reflection
    command: tuple[float, float] | None = None
    trigger: float | None = None  # s, of q5: fixed when it begins
    blocked: float = math.inf  # s, when the way was last not free, at rest

    @property
    def yaw(self) -> float:
        """rad, held."""
        return math.atan2(float(self.facing[1]), float(self.facing[0]))

    @property
    def left(self) -> Vector:
        """(2,) unit."""
        return np.array([-self.facing[1], self.facing[0]])

    def ahead_of(self, place: Vector) -> float:
        """m that a place (3,) is ahead of where it began."""
        return float((place - self.began)[:2] @ self.facing)

    def left_of(self, place: Vector) -> float:
        """m that a place (3,) is to the left of the line on which it began."""
        return float((place - self.began)[:2] @ self.left)


def begun(situation: Situation, found: Vector | None, delay: float) -> Manoeuvre:
    """At the commit time, along what is flown then. `delay`: s behind the reference."""
    state = situation.active.at(situation.commit)
    ahead = state.velocity_site[:2]
    speed = float(np.linalg.norm(ahead))
    yaw = situation.vehicle.yaw_site
    moves = speed > MOVING
    return Manoeuvre(
        facing=ahead / speed if moves else np.array([math.cos(yaw), math.sin(yaw)]),
        slope=float(state.velocity_site[2]) / speed if moves else 0.0,
        began=state.position_site,
        onto=min(situation.now - delay, situation.reference.end),
        obstacle=state.position_site if found is None else found,
    )


def beside_the_line(
    flown: Manoeuvre, situation: Situation, settings: AutomatonSettings, reading: Reading
) -> Reading:
    """Without what the side lasers see beyond the safe distance from the line that is flown back
    on: it is another thing."""
    reach = arm(situation.limits, situation.load) * math.sin(ALPHA)
    safe = safe_distance(settings, situation.limits, situation.load) + MARGIN - reach
    off = flown.left_of(situation.active.at(situation.now).position_site)
    s1, s2, s3, s4 = reading.lasers
    s2 = s2 if s2 < safe + max(-off, 0.0) else NOTHING
    s4 = s4 if s4 < safe + max(off, 0.0) else NOTHING
    return Reading(reading.ahead, reading.aside, (s1, s2, s3, s4))


def trigger_of_q5(
    flown: Manoeuvre,
    memory: Memory,
    situation: Situation,
    settings: AutomatonSettings,
    sizes: Numbers,
    view: View,
) -> float:
    """t_TR, s, for the gap there is to the obstacle's edge and the speed aside there is.

    A front laser that is free again has the edge beside it; a corner that no front laser has met is
    where the radar saw it.
    """
    rightwards = memory.state is State.Q3
    aside = flown.left if rightwards else -flown.left  # towards the obstacle
    here, then = situation.active.at(situation.now), situation.active.at(situation.commit)
    gap = arm(situation.limits, situation.load) * math.cos(ALPHA)
    gap += max(float((here.position_site - then.position_site)[:2] @ aside), 0.0)
    if not memory.touched(S1 if rightwards else S3):
        edge = view.edge(flown.obstacle, then.position_site, aside)
        gap = gap if math.isinf(edge) else edge
    moving = -float(then.velocity_site[:2] @ aside)
    left = safe_distance(settings, situation.limits, situation.load) - gap
    return trigger_time(left, moving, sizes.speed, situation.limits.acceleration)
