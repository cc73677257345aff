"""Safety speaks last: which hazards are seen, and what each means in each phase.

TABLE is the whole of it: every phase × every hazard has a cell. Hazards are listed by precedence,
the first one present decides. A cell names the phase to go to, or STAY.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from orchard_cli.model.vehicle import FlightMode, VehicleState

from .boundary import NO_EDGE, Margins
from .eyesight import Sight
from .haven import Haven
from .tracking import STEADY, Tracking


class Phase(Enum):
    """Where the flight stands."""

    PREFLIGHT = "preflight"
    TAKEOFF = "take-off"
    RESUME = "resume"  # getting to the route's next point and looking along it, then ROUTE
    ROUTE = "route"
    AVOIDANCE = "avoidance"
    HOLD = "hold"
    RETURN = "return"
    DIVERT = "diverting"  # to a free place near by, to land there
    LANDING = "landing"
    PILOT = "pilot"  # somebody or something else flies: keep quiet
    ENDED = "ended"


class Hazard(Enum):
    """What can be wrong, or be asked for, by precedence."""

    PILOT = "the pilot or another station changed the mode"
    CRASHED = "disarmed in the air or on the ground out of turn"
    FALLEN = "the vehicle has fallen"
    LAND_ASKED = "landing asked for"
    BATTERY_CRITICAL = "battery critical"
    LINK_SILENT = "no telemetry"
    CROSSED = "outside the fence or in a keep-out"
    RETURN_ASKED = "return asked for"
    BATTERY_LOW = "battery at the share needed to come back"
    WIND = "the wind is beyond what it should stand against"
    TANK_EMPTY = "the tank is empty"
    STRAYED = "the position estimate has jumped too far in this flight"
    HOLD_ASKED = "hold asked for"
    OBSTACLE = "an obstacle nearer than hard braking needs"
    EDGE_NEAR = "braking would end outside the fence or in a keep-out"
    JUMPED = "the position estimate jumped"
    GPS_LOST = "no GPS fix"
    OFF_TRACK = "the vehicle is not where it was sent"
    TRACKING = "tracking: the autopilot strays too far beside what it is told to fly"
    FRAME_BLANK = "the depth image is blank"
    FRAME_GARBLED = "the depth image is noise"
    FRAME_FROZEN = "the depth image does not change while the vehicle moves"
    FRAME_LATE = "no fresh depth frame"
    PLANNER_LATE = "the planner is late"
    BLOCKED = "no way round the obstacle"
    ALIVE = "a person or another drone ahead"
    LOG_LOST = "the log has lost records"


STAY = None
_P = Phase
_COLUMNS = (
    _P.PREFLIGHT, _P.TAKEOFF, _P.RESUME, _P.ROUTE, _P.AVOIDANCE,
    _P.HOLD, _P.RETURN, _P.DIVERT, _P.LANDING, _P.PILOT, _P.ENDED,
)  # fmt: skip
HOLD, BACK, LAND, EXIT, OVER = _P.HOLD, _P.RETURN, _P.LANDING, _P.PILOT, _P.ENDED
_ROWS: dict[Hazard, tuple[Phase | None, ...]] = {
    # hazard                  PREF  TAKE  RESU  ROUT  AVOI  HOLD  RETU  DIVE  LAND  PILO  ENDE
    Hazard.PILOT:            (STAY, EXIT, EXIT, EXIT, EXIT, EXIT, EXIT, EXIT, EXIT, STAY, STAY),
    Hazard.CRASHED:          (STAY, OVER, OVER, OVER, OVER, OVER, OVER, OVER, STAY, STAY, STAY),
    Hazard.FALLEN:           (STAY, STAY, LAND, LAND, LAND, LAND, LAND, LAND, STAY, STAY, STAY),
    Hazard.LAND_ASKED:       (OVER, LAND, LAND, LAND, LAND, LAND, LAND, LAND, STAY, STAY, STAY),
    Hazard.BATTERY_CRITICAL: (OVER, LAND, LAND, LAND, LAND, LAND, LAND, STAY, STAY, STAY, STAY),
    Hazard.LINK_SILENT:      (STAY, STAY, HOLD, HOLD, HOLD, STAY, HOLD, LAND, STAY, STAY, STAY),
    Hazard.CROSSED:          (STAY, LAND, BACK, BACK, BACK, BACK, STAY, LAND, STAY, STAY, STAY),
    Hazard.RETURN_ASKED:     (OVER, LAND, BACK, BACK, BACK, BACK, STAY, STAY, STAY, STAY, STAY),
    Hazard.BATTERY_LOW:      (OVER, LAND, BACK, BACK, BACK, BACK, STAY, STAY, STAY, STAY, STAY),
    Hazard.WIND:             (STAY, LAND, BACK, BACK, BACK, BACK, STAY, STAY, STAY, STAY, STAY),
    Hazard.TANK_EMPTY:       (STAY, STAY, BACK, BACK, BACK, BACK, STAY, STAY, STAY, STAY, STAY),
    Hazard.STRAYED:          (STAY, LAND, BACK, BACK, BACK, BACK, STAY, STAY, STAY, STAY, STAY),
    Hazard.HOLD_ASKED:       (OVER, LAND, HOLD, HOLD, HOLD, HOLD, HOLD, HOLD, STAY, STAY, STAY),
    Hazard.OBSTACLE:         (STAY, STAY, HOLD, HOLD, HOLD, STAY, HOLD, LAND, STAY, STAY, STAY),
    Hazard.EDGE_NEAR:        (STAY, STAY, HOLD, HOLD, HOLD, STAY, STAY, LAND, STAY, STAY, STAY),
    Hazard.JUMPED:           (STAY, STAY, HOLD, HOLD, HOLD, STAY, HOLD, LAND, STAY, STAY, STAY),
    Hazard.GPS_LOST:         (STAY, STAY, HOLD, HOLD, HOLD, STAY, HOLD, LAND, STAY, STAY, STAY),
    Hazard.OFF_TRACK:        (STAY, STAY, HOLD, HOLD, HOLD, STAY, HOLD, LAND, STAY, STAY, STAY),
    Hazard.TRACKING:         (STAY, STAY, HOLD, HOLD, HOLD, STAY, STAY, LAND, STAY, STAY, STAY),
    Hazard.FRAME_BLANK:      (STAY, STAY, HOLD, HOLD, HOLD, STAY, HOLD, LAND, STAY, STAY, STAY),
    Hazard.FRAME_GARBLED:    (STAY, STAY, HOLD, HOLD, HOLD, STAY, HOLD, LAND, STAY, STAY, STAY),
    Hazard.FRAME_FROZEN:     (STAY, STAY, HOLD, HOLD, HOLD, STAY, HOLD, LAND, STAY, STAY, STAY),
    Hazard.FRAME_LATE:       (STAY, STAY, HOLD, HOLD, HOLD, STAY, HOLD, STAY, STAY, STAY, STAY),
    Hazard.PLANNER_LATE:     (STAY, STAY, HOLD, HOLD, HOLD, STAY, HOLD, STAY, STAY, STAY, STAY),
    Hazard.BLOCKED:          (STAY, STAY, HOLD, HOLD, HOLD, STAY, HOLD, LAND, STAY, STAY, STAY),
    Hazard.ALIVE:            (STAY, STAY, HOLD, HOLD, HOLD, STAY, HOLD, LAND, STAY, STAY, STAY),
    Hazard.LOG_LOST:         (STAY, STAY, STAY, STAY, STAY, STAY, STAY, STAY, STAY, STAY, STAY),
}  # fmt: skip
TABLE: dict[tuple[Phase, Hazard], Phase | None] = {
    (phase, hazard): cell
    for hazard, row in _ROWS.items()
    for phase, cell in zip(_COLUMNS, row, strict=True)
}


TOLD = {Hazard.LOG_LOST}
"""Hazards that lead nowhere and are told all the same."""


class Request(Enum):
    """What the operator asks for."""

    HOLD = "hold"
    CONTINUE = "continue"
    RETURN = "return"
    LAND = "land"


@dataclass(frozen=True, slots=True)
class Tolerances:
    """When something counts as a hazard."""

    silence: float = 0.5  # s without telemetry: nothing is streamed, and a hold begins
    frame_age: float = 0.5  # s since the newest depth frame was taken
    planner_age: float = 0.5  # s since the last onboard cycle ended
    off_track: float = 1.5  # m between the vehicle and its setpoint
    lean: float = math.radians(15.0)  # rad against the wind; an X500 leans so in 12 m/s
    unfixed: float = 2.0  # s without a GPS fix
    empty_returns: bool = False  # an empty tank brings it back; else it flies on without spraying
    tracking: float = 1.0  # m beside what it is told to fly, lately: see tracking.py
    sunk: float = 1.5  # m under its setpoint: it falls
    falling: float = 0.3  # s of falling, or of lying on the ground, before it counts
    jumped: float = 1.0  # s for which a jump of the position estimate counts
    strayed: float = 4.0  # m by which the estimate may have jumped in all; the fence is off as much
    mode_grace: float = 2.0  # s, modes are told once a second


@dataclass(frozen=True, slots=True)
class Seen:
    """All that a decision is made from. Ages are infinite before the first arrival."""

    vehicle: VehicleState | None
    silence: float  # s since anything was heard
    frame_age: float  # s
    planner_age: float  # s
    off_track: float  # m between the vehicle and its setpoint; 0 when nothing is streamed
    falling: float  # s for which it has been far under its setpoint, or on the ground
    blocked: bool  # the last verdict was to stop
    avoiding: bool  # between leaving the reference and being back on it
    routed: bool  # there is a trajectory with a reference to fly
    joining: bool  # on the way to the route's next point
    climbed: bool  # near the height at which the trajectory starts
    still: bool  # standing at the end of what it was told to do
    joined: bool  # at the route's next point and looking along it
    route_done: bool
    return_share: float  # of the battery, needed to come back from here, with the reserve
    critical_share: float  # of the battery, below it land at once
    not_ready: tuple[str, ...]  # reasons against arming
    margins: Margins = NO_EDGE  # from fence and keep-outs
    since_jump: float = math.inf  # s since the position estimate jumped
    strayed: float = 0.0  # m by which it has jumped since arming, in all
    haven: Haven | None = None  # a free place near by, to come down on early
    sight: Sight = Sight.GOOD  # what has been wrong with the images for a while
    obstacle_near: bool = False  # nearer than hard braking needs
    alive: bool = False  # the avoidance system tells of somebody ahead
    unfixed: float = 0.0  # s without a GPS fix
    lean: float = 0.0  # rad, lately, to stand against the wind
    tank_empty: bool = False
    log_lost: bool = False  # records so far
    request: Request | None = None
    tracking: Tracking = STEADY  # how far it strays beside what it is told to fly
    refused: str | None = None  # what the autopilot said when it last refused


_OURS = {  # modes that this program itself brings about, by phase
    Phase.TAKEOFF: {FlightMode.TAKEOFF, FlightMode.HOLD},
    Phase.RESUME: {FlightMode.HOLD, FlightMode.TAKEOFF, FlightMode.OFFBOARD},
    Phase.ROUTE: {FlightMode.OFFBOARD},
    Phase.AVOIDANCE: {FlightMode.OFFBOARD},
    Phase.HOLD: {FlightMode.OFFBOARD, FlightMode.HOLD, FlightMode.TAKEOFF},
    Phase.RETURN: {FlightMode.OFFBOARD, FlightMode.HOLD},
    Phase.DIVERT: {FlightMode.OFFBOARD, FlightMode.HOLD},
    Phase.LANDING: {FlightMode.OFFBOARD, FlightMode.HOLD, FlightMode.TAKEOFF, FlightMode.LAND},
}


MODES_ASKED = {  # once the mode that a phase asks for was seen in it, every other is somebody's
    Phase.RESUME: FlightMode.OFFBOARD,
    Phase.HOLD: FlightMode.OFFBOARD,
    Phase.RETURN: FlightMode.OFFBOARD,
    Phase.DIVERT: FlightMode.OFFBOARD,
    Phase.LANDING: FlightMode.LAND,
}


def hazards(
    phase: Phase, age: float, engaged: bool, seen: Seen, tolerances: Tolerances
) -> tuple[Hazard, ...]:
    """Every hazard present, by precedence.

    `age` is the seconds since the phase began, `engaged` whether the autopilot was seen in it in
    the mode that the phase asks for.
    """
    signs = (
        *_of_the_vehicle(phase, age, engaged, seen, tolerances),
        *_of_the_way(seen, tolerances),
        *_of_the_eyes(seen, tolerances),
    )
    found = {hazard for is_present, hazard in signs if is_present}
    return tuple(hazard for hazard in Hazard if hazard in found) if found else ()


Sign = tuple[bool, Hazard]


def _of_the_vehicle(
    phase: Phase, age: float, engaged: bool, seen: Seen, tolerances: Tolerances
) -> tuple[Sign, ...]:
    """What the autopilot tells; on the ground nothing of it counts."""
    vehicle = seen.vehicle
    if vehicle is None or phase in (Phase.PREFLIGHT, Phase.ENDED):
        return ()
    ours = _OURS.get(phase, set(FlightMode))
    if engaged and phase in MODES_ASKED:
        ours = {MODES_ASKED[phase]}
    foreign = vehicle.armed and vehicle.mode not in ours
    sticks = vehicle.mode is FlightMode.PILOT
    landing = phase in (Phase.LANDING, Phase.PILOT)
    return (
        (sticks or (foreign and (engaged or age > tolerances.mode_grace)), Hazard.PILOT),
        (not vehicle.armed and not landing, Hazard.CRASHED),
        (vehicle.battery_share < seen.critical_share, Hazard.BATTERY_CRITICAL),
        (vehicle.battery_share < seen.return_share, Hazard.BATTERY_LOW),
        (seen.falling > tolerances.falling, Hazard.FALLEN),
    )


def _of_the_way(seen: Seen, tolerances: Tolerances) -> tuple[Sign, ...]:
    """What is asked for, and how the flight goes."""
    return (
        (seen.request is Request.LAND, Hazard.LAND_ASKED),
        (seen.request is Request.RETURN, Hazard.RETURN_ASKED),
        (seen.request is Request.HOLD, Hazard.HOLD_ASKED),
        (seen.silence > tolerances.silence, Hazard.LINK_SILENT),
        (seen.margins.here < 0, Hazard.CROSSED),
        (seen.margins.ahead < 0 <= seen.margins.here, Hazard.EDGE_NEAR),
        (seen.since_jump < tolerances.jumped, Hazard.JUMPED),
        (seen.strayed > tolerances.strayed, Hazard.STRAYED),
        (seen.unfixed > tolerances.unfixed, Hazard.GPS_LOST),
        (seen.off_track > tolerances.off_track, Hazard.OFF_TRACK),
        (seen.tracking.error > tolerances.tracking, Hazard.TRACKING),
        (seen.lean > tolerances.lean, Hazard.WIND),
        (seen.tank_empty and tolerances.empty_returns, Hazard.TANK_EMPTY),
        (seen.log_lost, Hazard.LOG_LOST),
    )


def _of_the_eyes(seen: Seen, tolerances: Tolerances) -> tuple[Sign, ...]:
    """What is seen ahead, and whether anything is."""
    return (
        (seen.obstacle_near, Hazard.OBSTACLE),
        (seen.sight is Sight.BLANK, Hazard.FRAME_BLANK),
        (seen.sight is Sight.GARBLED, Hazard.FRAME_GARBLED),
        (seen.sight is Sight.FROZEN, Hazard.FRAME_FROZEN),
        (seen.frame_age > tolerances.frame_age, Hazard.FRAME_LATE),
        (seen.planner_age > tolerances.planner_age, Hazard.PLANNER_LATE),
        (seen.blocked, Hazard.BLOCKED),
        (seen.alive, Hazard.ALIVE),
    )


def reaction(phase: Phase, found: tuple[Hazard, ...]) -> tuple[Phase, Hazard] | None:
    """Where the first hazard that matters here leads, or None to carry on."""
    for hazard in found:
        target = TABLE[phase, hazard]
        if target is not None:
            return target, hazard
    return None
