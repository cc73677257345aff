"""An autopilot that strays beside what it is told to fly gets room for it, or is held."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchard_cli.flight.phases import step
from orchard_cli.flight.safety import Hazard, Phase, Tolerances
from orchard_cli.flight.tracking import ASSUMED, MOST, Follower, Tracking, beside, widened
from orchard_cli.geometry.clearance import clearance
from orchard_cli.model.mission import Limits
from orchard_cli.model.records import LogLine, SafetyRecord
from orchard_cli.model.vehicle import Setpoint
from orchard_cli.model.world import Pole
from tests.laws.test_safety import decide, seen
from tests.loop import (
    fly,
    path,
    world_of,
)

ERRORS = st.floats(0.0, 3.0)


def setpoint(time=10.0, velocity=(1.0, 0.0, 0.0)):
    return Setpoint(time, np.array([5.0, 2.0, 3.0]), np.array(velocity), np.zeros(3), 0.0)


@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(-1, 1), st.floats(0.3, 3), st.floats(-3, 3))
def test_on_the_way_only_what_is_across_it_counts(along, across, above, speed, heading):
    way = np.array([math.cos(heading), math.sin(heading), 0.0])
    left = np.array([-way[1], way[0], 0.0])
    told = setpoint(velocity=way * speed)
    there = told.position_site + along * way + across * left + np.array([0, 0, above])
    assert beside(told, there, told.time) == pytest.approx(abs(across), abs=1e-9)


@given(st.floats(-2, 2), st.floats(-2, 2))
def test_while_it_stands_every_way_counts(x, y):
    told = setpoint(velocity=(0.0, 0.0, 0.0))
    assert beside(told, told.position_site + np.array([x, y, 0.5]), 10.0) == pytest.approx(
        math.hypot(x, y)
    )


def test_a_pose_is_judged_by_the_setpoint_that_was_meant_for_its_time():
    follower = Follower()
    follower.judge(np.array([50.0, 50.0, 3.0]), 9.0)  # nothing was streamed yet
    for k in range(20):
        turn = k * 0.02
        place = np.array([math.cos(turn), math.sin(turn), 3.0])
        follower.sent(Setpoint(turn, place, np.zeros(3), np.zeros(3), 0.0))
    follower.judge(np.array([math.cos(0.2), math.sin(0.2), 3.0]), 0.2)
    assert follower.tracking.error == pytest.approx(0.0, abs=1e-9)
    follower.stopped()
    follower.judge(np.array([9.0, 9.0, 3.0]), 0.5)
    assert follower.tracking.error == pytest.approx(0.0, abs=1e-9)


@given(st.lists(st.tuples(st.floats(0.0, 1.0), ERRORS), min_size=1, max_size=30))
def test_the_error_is_never_under_the_newest_and_fades_no_faster_than_it_says(steps):
    tracking, time = Tracking(), 0.0
    for dt, error in steps:
        time += dt
        before, tracking = tracking, tracking.after(error, time)
        assert tracking.error >= error
        assert tracking.error >= before.error * math.exp(-dt / 60) - 1e-9
        assert tracking.lasting >= before.lasting * math.exp(-dt / 300) - 1e-9
        assert tracking.error <= tracking.lasting <= max(error, before.lasting)


@given(ERRORS)
def test_the_widening_covers_the_excess_in_steps_up_to_its_limit(error):
    widening = Tracking(error, error).widening
    assert min(error - ASSUMED, MOST) - 1e-6 <= widening <= MOST
    assert round(widening / 0.1, 6) % 1 == pytest.approx(0.0, abs=1e-6)
    assert (widening == 0) == (error <= ASSUMED + 1e-10)


@given(st.floats(0.0, 1.0))
def test_up_to_where_it_is_held_no_error_reaches_the_airframe(error):
    limits = Limits()
    kept = widened(limits, Tracking(error, error).widening).clearance
    assert kept - error >= limits.airframe_radius - 1e-9
    assert error <= Tolerances().tracking


def test_an_autopilot_that_tracks_well_changes_no_limit_at_all():
    limits = Limits()
    assert widened(limits, Tracking(0.29, 0.29).widening) is limits


@pytest.mark.parametrize("phase", [Phase.RESUME, Phase.ROUTE, Phase.AVOIDANCE])
def test_beyond_the_limit_it_holds_and_goes_on_when_it_follows_again(phase):
    held = decide(phase, tracking=Tracking(1.05, 0.0)).stage
    assert (held.phase, held.cause) == (Phase.HOLD, Hazard.TRACKING)
    assert held.why.startswith("tracking")
    for error, then in ((0.9, Phase.HOLD), (0.7, Phase.RESUME)):
        later = step(held, seen(still=True, tracking=Tracking(error, 0.0)), 105.0, Tolerances())
        assert later.stage.phase is then


def test_the_planner_is_given_the_room_that_the_autopilot_needs(mission):
    """A vehicle that strays by 0.45 m passes a pole with the airframe and more to spare."""

    def stray(ideal):
        ideal.stray = 0.45

    world = world_of(mission, (Pole(7.5, 0.0, 0.15, 8.0),))
    ending, ideal, ledger = fly(mission, world, prepare=stray)
    assert ending.as_planned, ending
    assert clearance(world, path(ideal)).obstacles.min() >= mission.limits.clearance + 0.2
    flown = np.array([pose.position_site for pose in ideal.history])
    assert clearance(world, flown[flown[:, 2] > 1.0]).obstacles.min() > 0.6
    assert any("keep 1.05 m" in record.text for record in ledger.of(LogLine))
    assert max(record.tracking for record in ledger.of(SafetyRecord)) == pytest.approx(
        0.45, abs=0.05
    )
