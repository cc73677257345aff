"""What to do next: a pure function of where the flight stands and what is seen.

`step` asks the phase's own rule (rules.py), then lets safety overrule it (safety.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from orchard_cli.model.vehicle import Command, FlightMode

from .rules import RULES, off_plan, settled
from .safety import MODES_ASKED, TABLE, TOLD, Hazard, Phase, Seen, Tolerances, hazards, reaction
from .stage import Decision, Stage, Steer

ASK_AGAIN = 2.0  # s between two requests of the same thing: modes are told once a second


def begin(now: float) -> Stage:
    """The stage of a flight that has not begun."""
    return Stage(Phase.PREFLIGHT, now, "checking")


def step(stage: Stage, seen: Seen, now: float, tolerances: Tolerances) -> Decision:
    """Decide the next stage, what to stream and what to ask for."""
    found = hazards(stage.phase, now - stage.since, stage.engaged, seen, tolerances)
    overruled = reaction(stage.phase, found)
    if overruled is not None and overruled[0] is Phase.RETURN:
        again = next((h for h in found if TABLE[Phase.RETURN, h] is Phase.HOLD), None)
        if again is not None:  # it would be held again at once: home, as soon as that is safe
            stage = replace(stage, returning=True, as_planned=False)
            overruled = None if stage.phase is Phase.HOLD else (Phase.HOLD, again)
    if overruled is not None:
        target, hazard = overruled
        why = hazard.value if seen.refused is None else f"{hazard.value} ({seen.refused})"
        after = replace(off_plan(stage, target, now, why), cause=hazard)
    else:
        after = RULES[stage.phase](stage, seen, now, tolerances)
    after = settled(stage, after, seen, tolerances)
    after = replace(after, engaged=_engaged(stage, after, seen, tolerances))
    command = _WANTED.get(after.phase, _nothing)(after, seen)
    if command is not None and (command is not after.asked or now - after.asked_at > ASK_AGAIN):
        after = replace(after, asked=command, asked_at=now)
    else:
        command = None
    if stage.phase is Phase.PREFLIGHT and after.phase is Phase.ENDED and stage.asked is Command.ARM:
        command = Command.DISARM  # it may be arming at this moment
    held = stage.phase in (Phase.HOLD, Phase.DIVERT)
    matter = tuple(h for h in found if held or h in TOLD or TABLE[stage.phase, h])
    return Decision(after, _steer(after, found, seen, tolerances), command, matter)


def _engaged(stage: Stage, after: Stage, seen: Seen, tolerances: Tolerances) -> bool:
    """Whether the mode that the phase asks for has been seen in it, without silence since."""
    if seen.vehicle is None or seen.silence > tolerances.silence:
        return False
    kept = stage.engaged and after.phase is stage.phase
    return kept or seen.vehicle.mode is MODES_ASKED.get(after.phase)


def _nothing(stage: Stage, seen: Seen) -> Command | None:
    del stage, seen
    return None


def _arm(stage: Stage, seen: Seen) -> Command | None:
    """Asked once: whoever disarms by switch must not see the rotors start again."""
    ready = seen.vehicle is not None and not seen.not_ready and not seen.vehicle.armed
    return Command.ARM if ready and stage.asked is not Command.ARM else None


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
    Phase.DIVERT: _offboard,
    Phase.LANDING: _land,
}
_STEERS = {
    Phase.RESUME: Steer.JOIN,
    Phase.ROUTE: Steer.FOLLOW,
    Phase.AVOIDANCE: Steer.FOLLOW,
    Phase.HOLD: Steer.STAND,
    Phase.RETURN: Steer.GO_BACK,
    Phase.DIVERT: Steer.DIVERT,
}
_BLIND = {Hazard.FRAME_LATE, Hazard.PLANNER_LATE}


def _steer(stage: Stage, found: tuple[Hazard, ...], seen: Seen, tolerances: Tolerances) -> Steer:
    """A silent link gets no setpoint: an old one must not be obeyed when it comes back.

    On the way to a place to come down on, who sees nothing for a moment stands and waits for it.
    """
    if seen.silence > tolerances.silence:
        return Steer.NOTHING
    if stage.phase is Phase.DIVERT and not _BLIND.isdisjoint(found):
        return Steer.STAND
    return _STEERS.get(stage.phase, Steer.NOTHING)
