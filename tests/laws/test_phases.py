"""Each phase's own rule: when it is over, and what comes then."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from orchard_cli.flight.gauge import Gauge
from orchard_cli.flight.phases import step
from orchard_cli.flight.preflight import not_ready
from orchard_cli.flight.rules import MOST_HOLDS
from orchard_cli.flight.safety import Hazard, Phase, Request, Tolerances
from orchard_cli.flight.stage import Stage, Steer
from orchard_cli.flight.wind import Lean
from orchard_cli.model.tank import SPRAYER, Load
from orchard_cli.model.vehicle import Command, FlightMode, Landed
from tests.laws.test_safety import decide, seen, vehicle


def standing(**changes):
    """On the ground, disarmed."""
    values = {"armed": False, "landed": Landed.ON_GROUND, "mode": FlightMode.HOLD}
    return vehicle(**{**values, **changes})


def test_a_vehicle_that_is_ready_is_armed_once_and_then_takes_off():
    first = decide(Phase.PREFLIGHT, vehicle=standing())
    assert first.command is Command.ARM
    again = step(first.stage, seen(vehicle=standing()), 103.0, Tolerances())
    assert (again.stage.phase, again.command) == (Phase.PREFLIGHT, None)
    armed = step(again.stage, seen(vehicle=standing(armed=True)), 104.0, Tolerances())
    assert (armed.stage.phase, armed.command) == (Phase.TAKEOFF, Command.TAKEOFF)


def test_no_answer_to_arming_and_one_that_somebody_armed_end_before_take_off():
    asked = Stage(Phase.PREFLIGHT, 0.0, "checking", asked=Command.ARM, asked_at=1.0)
    mute = step(asked, seen(vehicle=standing()), 9.5, Tolerances()).stage
    assert (mute.phase, mute.as_planned) == (Phase.ENDED, False)
    assert "no answer" in mute.why
    assert "already armed" in decide(Phase.PREFLIGHT).stage.why


@pytest.mark.parametrize("refused", [None, "TEMPORARILY_REJECTED"])
def test_a_take_off_that_does_not_come_to_its_height_is_landed(refused):
    rising = vehicle(mode=FlightMode.TAKEOFF, landed=Landed.TAKING_OFF)
    state = {"vehicle": rising, "climbed": False, "refused": refused}
    assert decide(Phase.TAKEOFF, age=44.0, **state).stage.phase is Phase.TAKEOFF
    late = decide(Phase.TAKEOFF, age=46.0, **state).stage
    assert late.phase is Phase.LANDING
    assert (refused or "not at height") in late.why


def test_the_route_begins_when_it_is_joined_and_not_for_ever_later():
    assert decide(Phase.RESUME, joined=True).stage.phase is Phase.ROUTE
    assert decide(Phase.RESUME, age=44.0).stage.phase is Phase.RESUME
    late = decide(Phase.RESUME, age=46.0).stage
    assert late.phase is Phase.LANDING
    assert "no start" in late.why


def test_round_an_obstacle_and_back_onto_the_route():
    out = decide(Phase.ROUTE, avoiding=True).stage
    assert out.phase is Phase.AVOIDANCE
    assert step(out, seen(), 110.0, Tolerances()).stage.phase is Phase.ROUTE
    assert decide(Phase.AVOIDANCE, route_done=True).stage.phase is Phase.LANDING


@pytest.mark.parametrize(
    ("returning", "joining", "phase"),
    [
        (False, False, Phase.ROUTE),
        (False, True, Phase.RESUME),
        (True, False, Phase.RETURN),
    ],
)
def test_a_blocked_flight_goes_on_where_it_was_once_there_is_a_way(returning, joining, phase):
    held = Stage(Phase.HOLD, 90.0, "no way", cause=Hazard.BLOCKED, returning=returning)
    assert step(held, seen(joining=joining), 91.0, Tolerances()).stage.phase is phase


def test_the_operator_who_continues_is_heard_by_a_flight_that_sees():
    held = Stage(Phase.HOLD, 90.0, "asked", cause=Hazard.HOLD_ASKED)
    asked = {"request": Request.CONTINUE}
    assert step(held, seen(**asked), 91.0, Tolerances()).stage.phase is Phase.RESUME
    blind = step(held, seen(frame_age=2.0, **asked), 91.0, Tolerances())
    assert blind.steer is Steer.STAND
    assert step(held, seen(), 209.0, Tolerances()).stage.phase is Phase.HOLD
    assert step(held, seen(), 211.0, Tolerances()).stage.phase is Phase.RETURN


def test_a_flight_that_is_held_too_often_goes_home():
    held = Stage(Phase.HOLD, 90.0, "late", cause=Hazard.PLANNER_LATE, holds=MOST_HOLDS + 1)
    assert step(held, seen(still=True), 93.0, Tolerances()).stage.phase is Phase.RETURN


def test_a_landing_ends_on_the_ground_or_says_what_it_saw():
    assert decide(Phase.LANDING).command is Command.LAND
    under_way = vehicle(mode=FlightMode.LAND)
    assert decide(Phase.LANDING, vehicle=under_way).command is None
    down = decide(Phase.LANDING, vehicle=standing()).stage
    assert (down.phase, down.as_planned) == (Phase.ENDED, True)
    fallen = decide(Phase.LANDING, vehicle=vehicle(armed=False)).stage
    assert (fallen.phase, fallen.as_planned) == (Phase.ENDED, False)
    late = decide(Phase.LANDING, age=121.0, vehicle=under_way).stage
    assert "no touch-down" in late.why


@pytest.mark.parametrize("phase", [Phase.TAKEOFF, Phase.ROUTE, Phase.HOLD, Phase.DIVERT])
def test_a_vehicle_that_is_disarmed_in_the_air_is_the_end(phase):
    ended = decide(phase, vehicle=vehicle(armed=False)).stage
    assert (ended.phase, ended.cause) == (Phase.ENDED, Hazard.CRASHED)


def test_the_pilot_keeps_the_vehicle_until_it_is_disarmed_or_left_to_him():
    flown = vehicle(mode=FlightMode.PILOT)
    assert decide(Phase.PILOT, vehicle=flown).stage.phase is Phase.PILOT
    assert decide(Phase.PILOT, vehicle=standing()).stage.phase is Phase.ENDED
    left = decide(Phase.PILOT, vehicle=flown, request=Request.HOLD).stage
    assert (left.phase, "flies on" in left.why) == (Phase.ENDED, True)
    assert decide(Phase.ENDED, vehicle=flown).stage.phase is Phase.ENDED


def reasons(mission, **changes):
    ages = {"frame_age": changes.pop("frame_age", 0.1), "planner_age": changes.pop("planner", 0.1)}
    x, y = mission.takeoff_site
    state = standing(**{"position_site": np.array([x, y, 0.0]), **changes})
    return not_ready(mission, state, tolerances=Tolerances(), **ages)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"position_site": np.array([90.0, 0.0, 0.0])}, "carry it there"),
        ({"position_site": np.full(3, math.nan)}, "carry it there"),
        ({"landed": Landed.IN_AIR}, "on the ground"),
        ({"battery_share": math.nan}, "not known"),
        ({"battery_share": 0.21}, "change the battery"),
        ({"frame_age": 1.0}, "check the camera"),
        ({"planner": 1.0}, "map does not follow"),
        ({"not_ready": ("no GPS",)}, "no GPS"),
    ],
)
def test_every_reason_against_arming_is_told_with_its_mend(mission, changes, words):
    assert reasons(mission) == ()
    (only,) = reasons(mission, **changes)
    assert words in only


def test_without_telemetry_and_outside_the_fence_nothing_is_armed(mission):
    assert not_ready(mission, None, 0.1, 0.1, Tolerances())
    x, y = mission.takeoff_site
    ring = np.array([[x - 1, y - 1], [x + 1, y - 1], [x + 1, y + 1], [x - 1, y + 1]])
    fenced = SimpleNamespace(
        orchard=SimpleNamespace(fence_site=np.empty((0, 2)), keep_outs_site=(ring,)),
        takeoff_site=mission.takeoff_site,
        limits=mission.limits,
        energy_share=mission.energy_share,
    )
    (only,) = reasons(fenced)
    assert "outside the fence" in only


def test_a_tank_is_counted_down_while_the_pump_runs_and_gaps_are_not():
    asked = []
    gauge = Gauge(Load(SPRAYER, 0.5), asked.append)
    for now, on in ((0.0, True), (0.4, True), (60.4, False), (60.8, False)):
        gauge.run(on, now)
    assert asked == [True, False]
    assert gauge.used == pytest.approx(0.9 * SPRAYER.flow / 60)
    assert not gauge.empty
    assert Gauge(None, asked.append).used is None
    Gauge(None, asked.append).run(True, 0.0)
    assert asked == [True, False]


def test_a_look_that_is_no_newer_changes_no_lean():
    lean = Lean()
    lean.after(vehicle(time=1.0), np.array([5.0, 0.0, 0.0]))
    lean.after(vehicle(time=1.0), np.array([5.0, 0.0, 0.0]))
    assert lean.angle == 0.0
