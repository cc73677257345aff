"""The flight's phases and the safety table."""

import dataclasses
import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.flight.boundary import Margins
from orchard_cli.flight.eyesight import Sight
from orchard_cli.flight.haven import Haven
from orchard_cli.flight.phases import begin, step
from orchard_cli.flight.safety import TABLE, Hazard, Phase, Request, Seen, Tolerances, reaction
from orchard_cli.flight.stage import Stage, Steer
from orchard_cli.flight.tracking import Tracking
from orchard_cli.model.vehicle import Command, FlightMode, Landed, VehicleState

FLYING = (Phase.TAKEOFF, Phase.RESUME, Phase.ROUTE, Phase.AVOIDANCE, Phase.HOLD, Phase.RETURN)


def vehicle(**changes) -> VehicleState:
    values = {
        "time": 0.0,
        "position_site": np.zeros(3),
        "velocity_site": np.zeros(3),
        "site_from_body": np.array([1.0, 0, 0, 0]),
        "angular_velocity_body": np.zeros(3),
        "armed": True,
        "mode": FlightMode.OFFBOARD,
        "landed": Landed.IN_AIR,
        "heard": 0.0,
        "battery_share": 0.9,
        "battery_voltage": 16.0,
        "ready": True,
    }
    return VehicleState(**{**values, **changes})


def seen(**changes) -> Seen:
    values = {
        "vehicle": vehicle(),
        "silence": 0.02,
        "frame_age": 0.05,
        "planner_age": 0.05,
        "off_track": 0.1,
        "falling": 0.0,
        "routed": True,
        "joining": False,
        "climbed": True,
        "blocked": False,
        "avoiding": False,
        "still": False,
        "joined": False,
        "route_done": False,
        "return_share": 0.2,
        "critical_share": 0.1,
        "not_ready": (),
    }
    return Seen(**{**values, **changes})


def decide(phase: Phase, now: float = 100.0, age: float = 10.0, **changes):
    return step(Stage(phase, now - age, "test"), seen(**changes), now, Tolerances())


def test_every_phase_has_a_cell_for_every_hazard():
    assert set(TABLE) == set(itertools.product(Phase, Hazard))


@pytest.mark.parametrize("phase", FLYING)
@pytest.mark.parametrize("mode", [FlightMode.PILOT])
def test_the_pilots_mode_change_wins_and_is_never_fought(phase, mode):
    decision = decide(phase, age=0.1, vehicle=vehicle(mode=mode), request=Request.LAND)
    assert decision.stage.phase is Phase.PILOT
    assert decision.steer is Steer.NOTHING
    assert decision.command is None


@given(st.sampled_from(list(FlightMode)), st.floats(0, 100), st.booleans())
def test_nothing_is_streamed_or_asked_while_the_pilot_flies(mode, silence, armed):
    state = vehicle(mode=mode, armed=armed)
    decision = decide(Phase.PILOT, vehicle=state, silence=silence, request=Request.RETURN)
    assert decision.steer is Steer.NOTHING
    assert decision.command is None


@pytest.mark.parametrize("phase", [Phase.ROUTE, Phase.AVOIDANCE, Phase.RESUME, Phase.RETURN])
@pytest.mark.parametrize(
    "fault",
    [
        {"frame_age": 0.6},
        {"planner_age": 0.6},
        {"off_track": 2.0},
        {"blocked": True},
        {"silence": 1.2},
        {"request": Request.HOLD},
    ],
)
def test_each_fault_under_way_leads_to_a_hold(phase, fault):
    assert decide(phase, **fault).stage.phase is Phase.HOLD


@pytest.mark.parametrize("phase", list(Phase))
def test_no_setpoint_goes_out_on_a_silent_link(phase):
    assert decide(phase, silence=0.6).steer is Steer.NOTHING


def test_a_low_battery_brings_it_back_and_a_critical_one_down():
    low, critical = vehicle(battery_share=0.15), vehicle(battery_share=0.05)
    assert decide(Phase.ROUTE, vehicle=low).stage.phase is Phase.RETURN
    assert decide(Phase.ROUTE, vehicle=critical).stage.phase is Phase.LANDING


@pytest.mark.parametrize("phase", [Phase.RESUME, Phase.ROUTE, Phase.AVOIDANCE, Phase.HOLD])
@pytest.mark.parametrize(
    "sign",
    [{"falling": 2.0}, {"falling": 0.5, "off_track": 3.0}, {"falling": 2.0, "frame_age": 9}],
)
def test_a_vehicle_that_fell_is_landed_at_once_and_its_rotors_are_not_driven_on(phase, sign):
    decision = decide(phase, **sign)
    assert decision.stage.phase is Phase.LANDING
    assert decision.command is Command.LAND
    assert decision.steer is Steer.NOTHING


def test_an_unknown_battery_is_no_hazard_in_the_air():
    unknown = vehicle(battery_share=math.nan)
    assert decide(Phase.ROUTE, vehicle=unknown).stage.phase is Phase.ROUTE


def test_an_arming_refusal_ends_with_what_the_autopilot_said():
    asked = Stage(Phase.PREFLIGHT, 0.0, "checking", asked=Command.ARM, asked_at=1.0)
    grounded = vehicle(armed=False, landed=Landed.ON_GROUND, mode=FlightMode.HOLD)
    decision = step(asked, seen(vehicle=grounded, refused="GPS fix too low"), 2.0, Tolerances())
    assert decision.stage.phase is Phase.ENDED
    assert "GPS fix too low" in decision.stage.why


@pytest.mark.parametrize("request_", [Request.HOLD, Request.RETURN, Request.LAND])
def test_whatever_is_asked_for_while_it_arms_disarms_it(request_):
    asked = Stage(Phase.PREFLIGHT, 0.0, "checking", asked=Command.ARM, asked_at=1.0)
    grounded = vehicle(armed=False, landed=Landed.ON_GROUND, mode=FlightMode.HOLD)
    decision = step(asked, seen(vehicle=grounded, request=request_), 1.5, Tolerances())
    assert decision.stage.phase is Phase.ENDED
    assert decision.command is Command.DISARM


def test_waiting_to_become_ready_has_a_limit_and_a_reason():
    decision = step(begin(0.0), seen(vehicle=None, not_ready=("no GPS",)), 61.0, Tolerances())
    assert decision.stage.phase is Phase.ENDED
    assert "no GPS" in decision.stage.why


def test_a_hold_that_does_not_pass_goes_back_or_without_eyes_down():
    held = Stage(Phase.HOLD, 0.0, "no way", cause=Hazard.BLOCKED)
    assert step(held, seen(blocked=True), 31.0, Tolerances()).stage.phase is Phase.RETURN
    blind = Stage(Phase.HOLD, 0.0, "no frame", cause=Hazard.FRAME_LATE)
    assert step(blind, seen(frame_age=9.0), 31.0, Tolerances()).stage.phase is Phase.LANDING


@settings(max_examples=300)
@given(
    st.sampled_from(FLYING),
    st.lists(st.sampled_from(list(Hazard)), min_size=1, unique=True),
)
def test_the_first_hazard_that_matters_decides(phase, found):
    ordered = tuple(hazard for hazard in Hazard if hazard in found)
    answer = reaction(phase, ordered)
    if answer is None:
        assert all(TABLE[phase, hazard] is None for hazard in ordered)
    else:
        before = ordered[: ordered.index(answer[1])]
        assert all(TABLE[phase, hazard] is None for hazard in before)


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_every_flight_reaches_an_end_whatever_is_seen(data):
    """A vehicle that obeys commands, under random faults, ends within the sum of the limits."""
    stage, now = begin(0.0), 0.0
    mode, armed, landed = FlightMode.HOLD, False, Landed.ON_GROUND
    faults = data.draw(
        st.fixed_dictionaries(
            {
                "silence": st.sampled_from([0.02, 0.02, 2.0]),
                "frame_age": st.sampled_from([0.05, 0.05, 2.0]),
                "planner_age": st.sampled_from([0.05, 2.0]),
                "blocked": st.booleans(),
                "sight": st.sampled_from([Sight.GOOD, *Sight]),
                "unfixed": st.sampled_from([0.0, 0.0, 5.0]),
                "obstacle_near": st.booleans(),
                "alive": st.booleans(),
                "lean": st.sampled_from([0.0, 0.0, 0.5]),
                "tracking": st.sampled_from([Tracking(), Tracking(0.9), Tracking(1.5)]),
                "haven": st.sampled_from([None, Haven((0.0, 0.0), 0.0), Haven((4.0, 0.0), 4.0)]),
                "joined": st.booleans(),
                "route_done": st.booleans(),
                "still": st.booleans(),
            }
        )
    )
    landing_since = None
    while stage.phase is not Phase.ENDED:
        state = vehicle(mode=mode, armed=armed, landed=landed)
        decision = step(stage, seen(vehicle=state, **faults), now, Tolerances())
        if decision.command is Command.ARM:
            armed = True
        elif decision.command is Command.TAKEOFF:
            mode, landed = FlightMode.HOLD, Landed.IN_AIR
        elif decision.command is Command.OFFBOARD:
            mode = FlightMode.OFFBOARD
        elif decision.command is Command.LAND:
            mode, landing_since = FlightMode.LAND, now
        if landing_since is not None and now - landing_since > 10:
            armed, landed = False, Landed.ON_GROUND
        before, stage = stage, decision.stage
        now += 1.0
        if stage.phase is Phase.ROUTE and before.phase is Phase.ROUTE and now > 200:
            faults["route_done"] = True
        assert now < 1500, dataclasses.asdict(stage)


@settings(max_examples=300)
@given(
    st.sampled_from(FLYING),
    st.fixed_dictionaries(
        {
            "frame_age": st.sampled_from([0.05, 2.0]),
            "planner_age": st.sampled_from([0.05, 2.0]),
            "off_track": st.sampled_from([0.1, 3.0]),
            "blocked": st.booleans(),
            "sight": st.sampled_from(list(Sight)),
            "unfixed": st.sampled_from([0.0, 5.0]),
            "obstacle_near": st.booleans(),
            "alive": st.booleans(),
            "lean": st.sampled_from([0.0, 0.5]),
            "tracking": st.sampled_from([Tracking(), Tracking(1.5)]),
            "haven": st.sampled_from([None, Haven((4.0, 0.0), 4.0)]),
            "since_jump": st.sampled_from([math.inf, 0.3]),
            "strayed": st.sampled_from([0.0, 9.0]),
            "vehicle": st.sampled_from([vehicle(), vehicle(battery_share=0.15)]),
        }
    ),
)
def test_under_the_same_faults_the_phase_settles_and_does_not_go_to_and_fro(phase, faults):
    stage, now, visited = Stage(phase, 90.0, "test"), 100.0, [phase]
    for _ in range(30):
        stage = step(stage, seen(**faults), now, Tolerances()).stage
        now += 0.02
        if stage.phase is not visited[-1]:
            visited.append(stage.phase)
    assert len(visited) <= 4, visited


def test_held_with_a_low_battery_and_no_eyes_it_stands_and_goes_home_once_it_sees():
    held = Stage(Phase.HOLD, 90.0, "no frame", cause=Hazard.FRAME_LATE)
    low = vehicle(battery_share=0.15)
    blind = step(held, seen(vehicle=low, frame_age=2.0), 100.0, Tolerances()).stage
    assert blind.phase is Phase.HOLD
    assert blind.returning
    assert step(blind, seen(vehicle=low), 100.1, Tolerances()).stage.phase is Phase.RETURN


def test_a_jump_of_the_estimate_holds_and_then_goes_on_unless_it_has_strayed():
    jumped = decide(Phase.ROUTE, since_jump=0.0, strayed=1.5).stage
    assert (jumped.phase, jumped.cause) == (Phase.HOLD, Hazard.JUMPED)
    later = step(jumped, seen(still=True, since_jump=3.0), 103.0, Tolerances()).stage
    assert later.phase is Phase.RESUME
    assert decide(Phase.ROUTE, strayed=9.0).stage.phase is Phase.RETURN
    both = decide(Phase.ROUTE, since_jump=0.0, strayed=9.0).stage
    assert (both.phase, both.returning) == (Phase.HOLD, True)


def test_near_the_fence_it_holds_and_outside_it_goes_back():
    near = decide(Phase.ROUTE, margins=Margins(0.8, -0.2)).stage
    assert (near.phase, near.cause) == (Phase.HOLD, Hazard.EDGE_NEAR)
    assert decide(Phase.ROUTE, margins=Margins(-0.1, -0.9)).stage.phase is Phase.RETURN
    assert decide(Phase.RETURN, margins=Margins(-0.1, -0.9)).stage.phase is Phase.RETURN


OLD = {"frame_age": 0.51, "planner_age": 0.51, "silence": 0.51}


@given(
    st.sampled_from(list(Phase)),
    st.sampled_from(list(OLD)),
    st.sampled_from([None, *Request]),
    st.sampled_from([None, Haven((4.0, 0.0), 4.0)]),
    st.booleans(),
)
def test_no_setpoint_that_moves_is_made_half_a_second_after_a_fault(phase, old, asked, haven, low):
    """Eyes, planner or link older than 0.5 s: it stands, or nothing is streamed."""
    state = vehicle(battery_share=0.15 if low else 0.9)
    ages = {old: OLD[old]}
    decision = decide(phase, vehicle=state, request=asked, haven=haven, **ages)
    assert decision.steer in (Steer.STAND, Steer.NOTHING)


@given(st.sampled_from(FLYING), st.sampled_from(list(Request)), st.floats(0, 9), st.booleans())
def test_the_pilot_wins_over_whatever_else_is_wrong(phase, asked, lean, near):
    flown = vehicle(mode=FlightMode.PILOT, battery_share=0.01)
    decision = decide(
        phase, vehicle=flown, request=asked, lean=lean, obstacle_near=near, silence=0.1,
        sight=Sight.GARBLED, falling=1.0,
    )  # fmt: skip
    assert decision.stage.phase is Phase.PILOT
    assert (decision.steer, decision.command) == (Steer.NOTHING, None)
