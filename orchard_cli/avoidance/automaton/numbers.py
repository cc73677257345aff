"""The manoeuvre's distances and times: Ahmed 2022, eqs. 16-22 and 27-29."""

from __future__ import annotations

import math
from dataclasses import dataclass

from orchard_cli.model.mission import Limits
from orchard_cli.model.tank import Load

from .states import Numbers

ALPHA = math.radians(45.0)  # of the arms to the body's x
FIELD = math.radians(25.0)  # half of the radar's field of view: phi_max


@dataclass(frozen=True, slots=True)
class Drift:
    """The avoidance velocity of a liquid level: f(x) = a e^(b x) + c e^(d x), m/s (eq. 28).

    At this speed the drift, from the command to stop to the rest, is `distance`. As `orchard
    identify drift` fits it to the simulated sprayer at `acceleration`.
    """

    a: float
    b: float
    c: float
    d: float
    distance: float = 0.59  # m, d_DR (Ahmed 2022, Table 2)
    acceleration: float = 3.0  # m/s² that the tests were flown with, at most

    def speed(self, level: float) -> float:
        """v_A, m/s."""
        return self.a * math.exp(self.b * level) + self.c * math.exp(self.d * level)


@dataclass(frozen=True, slots=True)
class AutomatonSettings:
    """How far the automaton keeps away."""

    safe_arms: float = 2.0  # arms: the safe distance (eq. 16)
    drift: Drift = Drift(0.7640, 0.06403, -4.232e-4, 6.072)
    latency: float = 0.55  # s until a scan is a command that is flown: confirmed, and committed
    soonest: float = 0.3  # s that this takes at least: one scan to confirm, and the commitment
    lag: float = 0.4  # s by which the vehicle's velocity follows the commanded one


def safe_distance(settings: AutomatonSettings, limits: Limits, load: Load | None) -> float:
    """d_S = x l_DA (eq. 16); never under the mission's clearance."""
    return max(settings.safe_arms * arm(limits, load), limits.clearance)


def arm(limits: Limits, load: Load | None) -> float:
    """l_DA, m; of a vehicle that says nothing of its arms, the whole airframe's radius."""
    return limits.airframe_radius if load is None else load.vehicle.arm


def numbers(
    settings: AutomatonSettings, limits: Limits, load: Load | None, speed: float
) -> Numbers:
    """For a vehicle that flies at `speed` m/s. `limits` are those for its load.

    d_S1 = d_s / tan(phi_max) (eq. 22): the text has lost the fraction, and says that "a larger cone
    angle results in a smaller first safe distance". d_SD = v² / 2a (eqs. 17 and 19), with the
    acceleration that is flown when that is less than the greatest, and what is flown before the
    brakes bite.
    """
    safe, reach = safe_distance(settings, limits, load), arm(limits, load)
    slow = avoidance_speed(settings, limits, load)
    braking = limits.acceleration
    edge = reach * math.cos(ALPHA) + slow * settings.soonest
    return Numbers(
        slowdown=max(speed**2 - slow**2, 0.0) / (2 * braking)
        + speed * settings.latency
        + max(speed - slow, 0.0) * settings.lag,
        first_safe=safe / math.tan(FIELD),
        speed=slow,
        trigger=trigger_time(safe - edge, slow, slow, braking),
        corner=reach * math.sin(ALPHA),
    )


def trigger_time(left: float, moving: float, speed: float, acceleration: float) -> float:
    """t_TR = (left - d_DR) / v_A, s (eq. 29), to end `left` m further; it moves at `moving` m/s.

    d_DR is the drift that stays. The paper's velocity controller keeps all of it; here a position
    is followed, what is flown beyond the bend swings back, and what stays is the bend from v aside
    to v ahead, to which each axis has a share of the acceleration. Who has only just begun to move
    speeds up first: eq. 29 takes him to fly at v_A, and he would pass a corner that the radar alone
    has seen far too near.
    """
    share = acceleration / math.sqrt(2.0)
    moving = min(max(moving, 0.0), speed)
    risen = (2 * speed**2 - moving**2) / (2 * share)  # m: up to v_A, and bent away at once
    if left >= risen:
        return (speed - moving) / share + (left - risen) / speed
    if left <= moving**2 / (2 * share):
        return 0.0
    return (math.sqrt(moving**2 / 2 + share * left) - moving) / share


def avoidance_speed(settings: AutomatonSettings, limits: Limits, load: Load | None) -> float:
    """v_A: by the identified drift (eq. 27), and never more than keeps the drift by the limits."""
    t, a, drift = settings.latency, limits.acceleration, settings.drift.distance
    by_limits = a * (math.sqrt(t * t + 2 * drift / a) - t)  # v t + v² / 2a = drift
    identified = math.inf if load is None else settings.drift.speed(load.level)
    return min(by_limits, identified, limits.speed)
