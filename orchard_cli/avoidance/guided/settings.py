"""How `guided` looks, how far it keeps away, and what it tries in turn."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Attempt:
    """One way to go about a detour."""

    lead: float  # m of free reference between the obstacle and the rejoin point
    cruise: float = 1.0  # share of the reference's speed
    brake_to: float = math.inf  # m/s: first slow down to this along what is flown
    tight: bool = False  # without the room for tracking errors, which are small when slow
    room: float = 0.0  # m before the obstacle for each m/s of speed; with less it is not tried


@dataclass(frozen=True, slots=True)
class GuidedSettings:
    """How `guided` looks and how far it keeps away.

    `close` < `accept` < `aim` are added to Limits.clearance + half a cell: a new trajectory has
    room for tracking errors, and noise of one cell does not make it a case for another one.
    """

    look_ahead: float = 7.0  # m of path that is checked: a little more than a D455 sees
    close: float = 0.10  # m: a trajectory that comes nearer is worth replacing
    accept: float = 0.20  # m: a new trajectory must keep this
    aim: float = 0.30  # m: what the optimisation aims at
    tight: float = 0.02  # m: a slow one must keep this, where the map may be off by half a cell
    aim_tight: float = 0.06  # m: and is aimed at this
    below: float = 0.6  # m under the flight height that must be free; canopies begin at 0.85
    above: float = 0.85  # m over it: wires and nets
    half_size: float = 8.0  # m of the local map
    reach: float = 1.8  # m up to which distances are known
    window: float = 15.5  # m of reference in which a rejoin point is looked for
    ahead: float = 1.5  # m of free reference behind the rejoin point
    furthest: float = 5.0  # m beside the route: a longer way round is the pilot's to choose
    gentle: float = 0.6  # share of the acceleration limit for early braking
    hard: float = 1.0  # share of it for braking before a detour
    stop_short: float = 0.2  # m before the first place that is too near
    halvings: int = 3  # of the route's knot interval: a detour may begin at a quarter of it
    attempts: tuple[Attempt, ...] = (
        Attempt(4.5, room=1.6),
        Attempt(3.0, cruise=0.6, room=1.1),
        Attempt(3.0, cruise=0.5, brake_to=0.3),
        Attempt(2.0, cruise=0.35, brake_to=0.0, tight=True),
        Attempt(3.0, cruise=0.8, tight=True),
    )
