"""Why the commanded way must not be flown. Not in the paper: its automaton would fly on."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.motion.situation import Situation

from .manoeuvre import Manoeuvre
from .numbers import AutomatonSettings, arm
from .states import S1, S2, S3, S4, Memory, Reading, State
from .view import View

WIDEST = 15.0  # m that it flies sideways to find an obstacle's end, and
LONGEST = 40.0  # m forward along it
SIDEWAYS = (State.Q3, State.Q4, State.Q5, State.Q9, State.Q10)
FORWARD = (State.Q6, State.Q7, State.Q8)


def refusal(
    memory: Memory,
    flown: Manoeuvre,
    situation: Situation,
    reading: Reading,
    settings: AutomatonSettings,
    view: View,
) -> str:
    """What is in the way of the state's velocity; empty: nothing."""
    speed = float(np.linalg.norm(situation.active.at(situation.commit).velocity_site))
    stopping = speed * settings.latency + speed**2 / (2 * situation.limits.acceleration)
    room = stopping + situation.limits.airframe_radius
    if memory.state in (State.Q0, State.Q1):
        return "it is too near to turn aside" if reading.ahead < stopping else ""
    ahead = view.obstacle(situation, situation.limits.airframe_radius, sure=True)
    if ahead is not None:
        here = situation.vehicle.position_site
        if float(np.linalg.norm((ahead - here)[:2])) < room:
            return "something else stands ahead"
    beam = room - arm(situation.limits, situation.load) * math.sqrt(0.5)  # lasers sit that far out
    if memory.state in SIDEWAYS:
        return _sideways(memory, flown, situation, reading, beam)
    return _forward(flown, situation, reading, beam)


def _sideways(
    memory: Memory, flown: Manoeuvre, situation: Situation, reading: Reading, beam: float
) -> str:
    right = memory.state in (State.Q3, State.Q10)
    right = right or (memory.state is State.Q5 and memory.rightwards)
    if reading.lasers[S4 if right else S2] < beam:
        return f"something stands to the {'right' if right else 'left'}"
    if abs(flown.left_of(situation.active.at(situation.now).position_site)) > WIDEST:
        return f"no end of the obstacle within {WIDEST:.0f} m"
    return ""


def _forward(flown: Manoeuvre, situation: Situation, reading: Reading, beam: float) -> str:
    if min(reading.lasers[S1], reading.lasers[S3]) < beam:
        return "something else stands ahead"
    if flown.ahead_of(situation.active.at(situation.now).position_site) > LONGEST:
        return f"no end of the obstacle within {LONGEST:.0f} m"
    return ""
