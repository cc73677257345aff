"""What to do next: a pure function of where the flight stands and what is seen.

`step` first asks the phase's own rule, then lets safety overrule it (safety.py). Every wait has a
limit and ends with a reason.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

from orchard_cli.model.vehicle import Command, FlightMode, Landed

from .safety import TABLE, Hazard, Phase, Request, Seen, Tolerances, hazards, reaction

ASK_AGAIN = 2.0  # s between two requests of the same thing: modes are told once a second
READY_LIMIT = 60.0  # s for the autopilot to become ready
ARM_LIMIT = 8.0
TAKEOFF_LIMIT = 45.0
JOIN_LIMIT = 45.0
HOLD_LIMIT = 30.0  # s to wait for a cause to go away before returning
CHOICE_LIMIT = 120.0  # s to wait for the operator's choice before returning
LANDING_LIMIT = 120.0
AWAKE = 0.3  # s: nothing older counts as fresh when deciding to go on


class Steer(Enum):
    """What the setpoint stream does."""

    NOTHING = "nothing"  # no stream: the autopilot flies by its own mode
    STAND = "stand"  # brake along the trajectory, then stand
    JOIN = "join"  # go to the route's next point and look along it
    FOLLOW = "follow"  # fly the route
    GO_BACK = "go back"  # fly the way home


@dataclass(frozen=True, slots=True)
class Stage:
    """Where the flight stands, since when, and why."""

    phase: Phase
    since: float  # s, flight clock
    why: str
    cause: Hazard | None = None  # what led here, when safety did
    asked: Command | None = None  # newest command, and when
    asked_at: float = 0.0
    as_planned: bool = True  # False once the flight has been ended early
    returning: bool = False  # on the way home, also while held there


@dataclass(frozen=True, slots=True)
class Decision:
    """What to do in this cycle."""

    stage: Stage
    steer: Steer
    command: Command | None
    hazards: tuple[Hazard, ...]  # those that matter in this phase


def begin(now: float) -> Stage:
    """The stage of a flight that has not begun."""
    return Stage(Phase.PREFLIGHT, now, "checking")


def step(stage: Stage, seen: Seen, now: float, tolerances: Tolerances) -> Decision:
    """Decide the next stage, what to stream and what to ask for."""
    found = hazards(stage.phase, now - stage.since, seen, tolerances)
    overruled = reaction(stage.phase, found)
    if overruled is not None:
        target, hazard = overruled
        after = replace(_off_plan(stage, target, now, hazard.value), cause=hazard)
    else:
        after = _RULES[stage.phase](stage, seen, now)
    command = _WANTED.get(after.phase, _nothing)(after, seen)
    if command is not None and (command is not after.asked or now - after.asked_at > ASK_AGAIN):
        after = replace(after, asked=command, asked_at=now)
    else:
        command = None
    matter = tuple(h for h in found if stage.phase is Phase.HOLD or TABLE[stage.phase, h])
    return Decision(after, _steer(after, seen), command, matter)


def _to(stage: Stage, phase: Phase, now: float, why: str) -> Stage:
    returning = stage.returning or phase is Phase.RETURN
    return Stage(phase, now, why, as_planned=stage.as_planned, returning=returning)


def _off_plan(stage: Stage, phase: Phase, now: float, why: str) -> Stage:
    early = phase in (Phase.RETURN, Phase.LANDING, Phase.PILOT, Phase.ENDED)
    after = _to(stage, phase, now, why)
    return replace(after, as_planned=stage.as_planned and not early)


def _preflight(stage: Stage, seen: Seen, now: float) -> Stage:
    waited = now - stage.since
    if seen.vehicle is not None and seen.vehicle.armed:
        return _to(stage, Phase.TAKEOFF, now, "armed")
    if stage.asked is Command.ARM:
        if now - stage.asked_at > ARM_LIMIT or seen.refused is not None:
            said = seen.refused or f"no answer within {ARM_LIMIT:.0f} s"
            return _off_plan(stage, Phase.ENDED, now, f"arming refused: {said}")
    elif waited > READY_LIMIT:
        reasons = "; ".join(seen.not_ready) or "unknown reason"
        return _off_plan(stage, Phase.ENDED, now, f"not ready after {READY_LIMIT:.0f} s: {reasons}")
    return stage


def _takeoff(stage: Stage, seen: Seen, now: float) -> Stage:
    vehicle = seen.vehicle
    if vehicle is not None and vehicle.landed is Landed.IN_AIR and vehicle.mode is FlightMode.HOLD:
        return _to(stage, Phase.RESUME, now, "at flight height")
    if now - stage.since > TAKEOFF_LIMIT:
        return _off_plan(stage, Phase.LANDING, now, f"not at height after {TAKEOFF_LIMIT:.0f} s")
    return stage


def _resume(stage: Stage, seen: Seen, now: float) -> Stage:
    if seen.joined:
        return _to(stage, Phase.ROUTE, now, "on the route")
    if now - stage.since > JOIN_LIMIT:
        said = seen.refused or "the route's next point was not reached"
        return _off_plan(stage, Phase.LANDING, now, f"no start within {JOIN_LIMIT:.0f} s: {said}")
    return stage


def _route(stage: Stage, seen: Seen, now: float) -> Stage:
    if seen.route_done:
        return _to(stage, Phase.LANDING, now, "route flown")
    if seen.avoiding and stage.phase is Phase.ROUTE:
        return _to(stage, Phase.AVOIDANCE, now, "leaving the route around an obstacle")
    if not seen.avoiding and stage.phase is Phase.AVOIDANCE:
        return _to(stage, Phase.ROUTE, now, "back on the route")
    return stage


def _hold(stage: Stage, seen: Seen, now: float) -> Stage:
    waited = now - stage.since
    onward = Phase.RETURN if stage.returning else Phase.RESUME
    if stage.cause is Hazard.BLOCKED and not seen.blocked:
        moving = Phase.RETURN if stage.returning else Phase.ROUTE
        return _to(stage, moving, now, "a way round was found")
    if seen.request is Request.CONTINUE:
        return _to(stage, onward, now, "the operator said so")
    if stage.cause in _PASSING and seen.still and waited > 1.0 and _awake(seen):
        return _to(stage, onward, now, f"over: {stage.why}")
    if waited > (CHOICE_LIMIT if stage.cause is Hazard.HOLD_ASKED else HOLD_LIMIT):
        return _give_up(stage, seen, now)
    return stage


_PASSING = {Hazard.FRAME_LATE, Hazard.PLANNER_LATE, Hazard.OFF_TRACK, Hazard.LINK_SILENT}


def _awake(seen: Seen) -> bool:
    """Whether eyes, planner and link are all fresh and the vehicle is where it should be."""
    ages = (seen.frame_age, seen.planner_age, seen.silence)
    return max(ages) < AWAKE and seen.off_track < 0.5


def _give_up(stage: Stage, seen: Seen, now: float) -> Stage:
    """Back the way it came, which was seen free; without eyes, or held there too, down."""
    able = _awake(seen) and not stage.returning
    target = Phase.RETURN if able else Phase.LANDING
    return _off_plan(stage, target, now, f"held {now - stage.since:.0f} s: {stage.why}")


def _return(stage: Stage, seen: Seen, now: float) -> Stage:
    if seen.route_done:
        return _off_plan(stage, Phase.LANDING, now, f"back at the take-off point: {stage.why}")
    return stage


def _landing(stage: Stage, seen: Seen, now: float) -> Stage:
    vehicle = seen.vehicle
    if vehicle is not None and not vehicle.armed:
        return _to(stage, Phase.ENDED, now, f"landed: {stage.why}")
    if now - stage.since > LANDING_LIMIT:
        return _off_plan(
            stage, Phase.ENDED, now, f"no touch-down seen within {LANDING_LIMIT:.0f} s"
        )
    return stage


def _pilot(stage: Stage, seen: Seen, now: float) -> Stage:
    if seen.vehicle is not None and not seen.vehicle.armed:
        return _off_plan(stage, Phase.ENDED, now, "disarmed after the pilot took over")
    return stage


def _ended(stage: Stage, seen: Seen, now: float) -> Stage:
    del seen, now
    return stage


_RULES: dict[Phase, Callable[[Stage, Seen, float], Stage]] = {
    Phase.PREFLIGHT: _preflight,
    Phase.TAKEOFF: _takeoff,
    Phase.RESUME: _resume,
    Phase.ROUTE: _route,
    Phase.AVOIDANCE: _route,
    Phase.HOLD: _hold,
    Phase.RETURN: _return,
    Phase.LANDING: _landing,
    Phase.PILOT: _pilot,
    Phase.ENDED: _ended,
}


def _nothing(stage: Stage, seen: Seen) -> Command | None:
    del stage, seen
    return None


def _arm(stage: Stage, seen: Seen) -> Command | None:
    del stage
    return Command.ARM if seen.vehicle is not None and not seen.not_ready else None


def _climb(stage: Stage, seen: Seen) -> Command | None:
    """Asked once: a second take-off command would start the climb anew."""
    del seen
    return Command.TAKEOFF if stage.asked is not Command.TAKEOFF else None


def _offboard(stage: Stage, seen: Seen) -> Command | None:
    del stage
    engaged = seen.vehicle is None or seen.vehicle.mode is FlightMode.OFFBOARD
    return None if engaged or seen.silence > 0.5 else Command.OFFBOARD


def _land(stage: Stage, seen: Seen) -> Command | None:
    del stage
    landing = seen.vehicle is not None and seen.vehicle.mode is FlightMode.LAND
    return None if landing else Command.LAND


_WANTED: dict[Phase, Callable[[Stage, Seen], Command | None]] = {
    Phase.PREFLIGHT: _arm,
    Phase.TAKEOFF: _climb,
    Phase.RESUME: _offboard,
    Phase.HOLD: _offboard,
    Phase.RETURN: _offboard,
    Phase.LANDING: _land,
}
_STEERS = {
    Phase.RESUME: Steer.JOIN,
    Phase.ROUTE: Steer.FOLLOW,
    Phase.AVOIDANCE: Steer.FOLLOW,
    Phase.HOLD: Steer.STAND,
    Phase.RETURN: Steer.GO_BACK,
}


def _steer(stage: Stage, seen: Seen) -> Steer:
    """A silent link gets no setpoint: an old one must not be obeyed when it comes back."""
    if seen.silence > 0.5:
        return Steer.NOTHING
    return _STEERS.get(stage.phase, Steer.NOTHING)
