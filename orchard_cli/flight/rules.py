"""Each phase's own rule: when it is over, and what comes then. Every wait has a limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from orchard_cli.model.vehicle import Command, FlightMode, Landed

from .eyesight import Sight
from .safety import Hazard, Phase, Request, Seen, Tolerances
from .stage import Stage

READY_LIMIT = 60.0  # s for the autopilot to become ready
ARM_LIMIT = 8.0
TAKEOFF_LIMIT = 45.0
JOIN_LIMIT = 45.0
HOLD_LIMIT = 30.0  # s to wait for a cause to go away before returning
CHOICE_LIMIT = 120.0  # s to wait for the operator's choice before returning
LANDING_LIMIT = 120.0
DIVERT_LIMIT = 30.0  # s to get to the place to come down on
AWAKE = 0.3  # s: nothing older counts as fresh when deciding to go on
CALMED = 0.8  # of the tracking tolerance, at which it counts as kept again
CALM = 2.0  # s of holding at least
MOST_HOLDS = 20  # in one flight: more often than that it does not set out again


def to(stage: Stage, phase: Phase, now: float, why: str) -> Stage:
    """The next stage, with what is carried over."""
    return Stage(
        phase,
        now,
        why,
        as_planned=stage.as_planned,
        returning=stage.returning or phase is Phase.RETURN,
        holds=stage.holds + (phase is Phase.HOLD),
    )


def off_plan(stage: Stage, phase: Phase, now: float, why: str) -> Stage:
    """The next stage; phases that end a flight early mark it so."""
    early = phase in (Phase.RETURN, Phase.DIVERT, Phase.LANDING, Phase.PILOT, Phase.ENDED)
    after = to(stage, phase, now, why)
    return replace(after, as_planned=stage.as_planned and not early)


def _preflight(stage: Stage, seen: Seen, now: float, tolerances: Tolerances) -> Stage:
    del tolerances
    armed = seen.vehicle is not None and seen.vehicle.armed
    if stage.asked is Command.ARM:
        if armed:
            return to(stage, Phase.TAKEOFF, now, "armed")
        if now - stage.asked_at > ARM_LIMIT or seen.refused is not None:
            said = seen.refused or f"no answer within {ARM_LIMIT:.0f} s"
            return off_plan(stage, Phase.ENDED, now, f"arming refused: {said}")
    elif armed:
        return off_plan(stage, Phase.ENDED, now, "already armed: somebody flies it; disarm first")
    elif now - stage.since > READY_LIMIT:
        reasons = "; ".join(seen.not_ready) or "unknown reason"
        return off_plan(stage, Phase.ENDED, now, f"not ready after {READY_LIMIT:.0f} s: {reasons}")
    return stage


def _takeoff(stage: Stage, seen: Seen, now: float, tolerances: Tolerances) -> Stage:
    del tolerances
    vehicle = seen.vehicle
    up = vehicle is not None and vehicle.landed is Landed.IN_AIR and seen.climbed
    if up and vehicle is not None and vehicle.mode is FlightMode.HOLD:
        return to(stage, Phase.RESUME, now, "at flight height")
    if now - stage.since > TAKEOFF_LIMIT:
        said = "" if seen.refused is None else f": {seen.refused}"
        why = f"not at height after {TAKEOFF_LIMIT:.0f} s{said}"
        return off_plan(stage, Phase.LANDING, now, why)
    return stage


def _resume(stage: Stage, seen: Seen, now: float, tolerances: Tolerances) -> Stage:
    del tolerances
    if seen.joined:
        return to(stage, Phase.ROUTE, now, "on the route")
    if now - stage.since > JOIN_LIMIT:
        said = seen.refused or "the route's next point was not reached"
        return off_plan(stage, Phase.LANDING, now, f"no start within {JOIN_LIMIT:.0f} s: {said}")
    return stage


def _route(stage: Stage, seen: Seen, now: float, tolerances: Tolerances) -> Stage:
    del tolerances
    if seen.route_done:
        return to(stage, Phase.LANDING, now, "route flown")
    if seen.avoiding and stage.phase is Phase.ROUTE:
        return to(stage, Phase.AVOIDANCE, now, "leaving the route around an obstacle")
    if not seen.avoiding and stage.phase is Phase.AVOIDANCE:
        return to(stage, Phase.ROUTE, now, "back on the route")
    return stage


def _hold(stage: Stage, seen: Seen, now: float, tolerances: Tolerances) -> Stage:
    waited = now - stage.since
    onward = Phase.RETURN if stage.returning else Phase.RESUME
    if stage.cause is Hazard.BLOCKED and not seen.blocked and seen.routed:
        moving = Phase.RESUME if seen.joining else Phase.ROUTE
        moving = Phase.RETURN if stage.returning else moving
        return to(stage, moving, now, "a way round was found")
    if seen.request is Request.CONTINUE and _awake(seen, tolerances):
        return to(stage, onward, now, "the operator said so")
    passing = stage.cause in _PASSING or (stage.cause is Hazard.BLOCKED and not seen.routed)
    if passing and seen.still and waited > CALM and _awake(seen, tolerances):
        if stage.holds > MOST_HOLDS:
            return _give_up(stage, seen, now, tolerances)
        return to(stage, onward, now, f"over: {stage.why}")
    if waited > (CHOICE_LIMIT if stage.cause is Hazard.HOLD_ASKED else HOLD_LIMIT):
        return _give_up(stage, seen, now, tolerances)
    return stage


_PASSING = {
    Hazard.FRAME_LATE,
    Hazard.PLANNER_LATE,
    Hazard.OBSTACLE,
    Hazard.GPS_LOST,
    Hazard.FRAME_BLANK,
    Hazard.FRAME_GARBLED,
    Hazard.FRAME_FROZEN,
    Hazard.ALIVE,
    Hazard.OFF_TRACK,
    Hazard.TRACKING,
    Hazard.LINK_SILENT,
    Hazard.JUMPED,
    Hazard.EDGE_NEAR,
}


def _awake(seen: Seen, tolerances: Tolerances) -> bool:
    """Whether eyes, planner and link are all fresh and the vehicle is where it should be.

    A tolerance that is infinite (a flight without eyes) is not asked for.
    """
    ages = (
        (seen.frame_age, tolerances.frame_age),
        (seen.planner_age, tolerances.planner_age),
        (seen.silence, tolerances.silence),
    )
    fresh = all(age < AWAKE or math.isinf(limit) for age, limit in ages)
    follows = seen.off_track < 0.5 and seen.tracking.error < CALMED * tolerances.tracking
    clear = seen.sight is Sight.GOOD and not seen.obstacle_near and not seen.alive
    placed = seen.unfixed <= 0.0 and seen.since_jump > CALM and seen.margins.ahead >= 0
    return fresh and follows and clear and placed


_EARLY = {Phase.RESUME, Phase.ROUTE, Phase.AVOIDANCE, Phase.HOLD, Phase.RETURN}


def settled(before: Stage, after: Stage, seen: Seen, tolerances: Tolerances) -> Stage:
    """A landing out of turn, at a free place near by where one is known; else as it was decided.

    It is gone to by those alone that see, follow and have not fallen.
    """
    home = seen.route_done and after.cause is None
    if after.phase is not Phase.LANDING or before.phase not in _EARLY or home:
        return after
    able = _awake(seen, tolerances) and after.cause is not Hazard.FALLEN
    if seen.haven is None or not able:
        return replace(after, why=f"{after.why}; where it is, no place near by is known to be free")
    if not seen.haven.away:
        return after
    why = f"{after.why}; on a free place {seen.haven.away:.1f} m away"
    place = seen.haven.place_site
    return replace(after, phase=Phase.DIVERT, why=why, place_site=place)


def _give_up(stage: Stage, seen: Seen, now: float, tolerances: Tolerances) -> Stage:
    """Back the way it came, which was seen free; without eyes, or held there too, down."""
    able = _awake(seen, tolerances) and not stage.returning
    target = Phase.RETURN if able else Phase.LANDING
    why = f"held {now - stage.since:.0f} s, {stage.holds} times so far: {stage.why}"
    return off_plan(stage, target, now, why)


def _return(stage: Stage, seen: Seen, now: float, tolerances: Tolerances) -> Stage:
    del tolerances
    if seen.route_done:
        return off_plan(stage, Phase.LANDING, now, f"back at the take-off point: {stage.why}")
    return stage


def _divert(stage: Stage, seen: Seen, now: float, tolerances: Tolerances) -> Stage:
    del tolerances
    if seen.route_done or now - stage.since > DIVERT_LIMIT:
        return off_plan(stage, Phase.LANDING, now, stage.why)
    return stage


def _landing(stage: Stage, seen: Seen, now: float, tolerances: Tolerances) -> Stage:
    del tolerances
    vehicle = seen.vehicle
    if vehicle is not None and not vehicle.armed:
        if vehicle.landed is Landed.IN_AIR:
            return off_plan(stage, Phase.ENDED, now, f"disarmed in the air: {stage.why}")
        return to(stage, Phase.ENDED, now, f"landed: {stage.why}")
    if now - stage.since > LANDING_LIMIT:
        return off_plan(stage, Phase.ENDED, now, f"no touch-down seen within {LANDING_LIMIT:.0f} s")
    return stage


def _pilot(stage: Stage, seen: Seen, now: float, tolerances: Tolerances) -> Stage:
    del tolerances
    if seen.vehicle is not None and not seen.vehicle.armed:
        return off_plan(stage, Phase.ENDED, now, "disarmed after the pilot took over")
    if seen.request is not None:
        return off_plan(stage, Phase.ENDED, now, "left to the pilot, who flies on")
    return stage


def _ended(stage: Stage, seen: Seen, now: float, tolerances: Tolerances) -> Stage:
    del seen, now, tolerances
    return stage


RULES: dict[Phase, Callable[[Stage, Seen, float, Tolerances], Stage]] = {
    Phase.PREFLIGHT: _preflight,
    Phase.TAKEOFF: _takeoff,
    Phase.RESUME: _resume,
    Phase.ROUTE: _route,
    Phase.AVOIDANCE: _route,
    Phase.HOLD: _hold,
    Phase.RETURN: _return,
    Phase.DIVERT: _divert,
    Phase.LANDING: _landing,
    Phase.PILOT: _pilot,
    Phase.ENDED: _ended,
}
