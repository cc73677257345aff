"""The automaton of Ahmed 2022, row by row of Table 1, and what it makes of it in the air."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.avoidance.automaton import AutomatonSettings, Dfa, steered
from orchard_cli.avoidance.automaton.course import back_to_route
from orchard_cli.avoidance.automaton.numbers import avoidance_speed, numbers, trigger_time
from orchard_cli.avoidance.automaton.reflections import Reflections
from orchard_cli.avoidance.automaton.states import (
    NOTHING,
    Memory,
    Numbers,
    Reading,
    State,
    advance,
    step,
    velocity,
)
from orchard_cli.avoidance.automaton.view import View
from orchard_cli.geometry.rotations import from_yaw_pitch_roll
from orchard_cli.model.mission import Limits
from orchard_cli.model.sensors import RadarScan, plant_protection_radar
from orchard_cli.model.tank import SPRAYER, Load
from orchard_cli.model.vehicle import FlightMode, Landed, VehicleState
from orchard_cli.motion.situation import Avoid, Keep, Stop

from ..pole_world import PoleMap, fly, same_until, situation, straight_route

SIZES = Numbers(slowdown=4.0, first_safe=2.0, speed=1.0, trigger=0.5, corner=0.35)
FREE = (NOTHING,) * 4
TOUCHED = {0: "S1", 1: "S2", 2: "S3", 3: "S4"}


def at(state, **more):
    return Memory(state=state, **more)


def lasers(**found):
    return tuple(found.get(name, NOTHING) for name in ("s1", "s2", "s3", "s4"))


def met(**found):
    return lasers(**found)


ROWS = [  # memory, reading, next state; in the order of Table 1
    (at(State.Q0), Reading(6.0, 0.0, FREE), State.Q1),
    (at(State.Q0), Reading(6.1, 0.0, FREE), State.Q0),
    (at(State.Q1), Reading(2.0, 0.0, FREE), State.Q2),
    (at(State.Q1), Reading(2.1, 0.0, FREE), State.Q1),
    (at(State.Q2), Reading(2.0, 0.0, FREE), State.Q3),
    (at(State.Q2), Reading(2.0, 0.3, FREE), State.Q3),
    (at(State.Q2), Reading(2.0, -0.3, FREE), State.Q4),
    (at(State.Q2), Reading(2.0, -0.3, lasers(s1=2.0, s3=3.0)), State.Q3),
    (at(State.Q2), Reading(2.0, 0.3, lasers(s1=3.0, s3=2.0)), State.Q4),
    (at(State.Q3), Reading(2.0, 0.3, FREE), State.Q3),
    (at(State.Q3), Reading(2.0, 0.4, FREE), State.Q5),
    (at(State.Q3), Reading(2.0, 0.4, lasers(s1=2.0)), State.Q3),
    (at(State.Q3, nearest=met(s1=2.0)), Reading(2.0, 0.1, FREE), State.Q5),
    (at(State.Q4), Reading(2.0, -0.3, FREE), State.Q4),
    (at(State.Q4), Reading(2.0, -0.4, FREE), State.Q5),
    (at(State.Q4), Reading(2.0, 0.4, FREE), State.Q4),
    (at(State.Q4, nearest=met(s3=2.0)), Reading(2.0, 0.1, FREE), State.Q5),
    (at(State.Q5, rightwards=True, since=-1.0), Reading(2.0, 0.4, FREE), State.Q6),
    (at(State.Q5, since=-1.0), Reading(2.0, 0.4, FREE), State.Q7),
    (at(State.Q5, rightwards=True), Reading(2.0, 0.4, FREE), State.Q5),
    (at(State.Q6), Reading(NOTHING, math.nan, FREE), State.Q6),
    (at(State.Q6), Reading(NOTHING, math.nan, lasers(s2=1.0)), State.Q6),
    (at(State.Q6, nearest=met(s2=1.0)), Reading(NOTHING, math.nan, FREE), State.Q8),
    (at(State.Q7, nearest=met(s4=1.0)), Reading(NOTHING, math.nan, FREE), State.Q8),
    (at(State.Q8, since=-1.0, nearest=met(s2=1.0)), Reading(NOTHING, math.nan, FREE), State.Q9),
    (at(State.Q8, since=-1.0, nearest=met(s4=1.0)), Reading(NOTHING, math.nan, FREE), State.Q10),
    (at(State.Q9, counted=1.0), Reading(NOTHING, math.nan, FREE), State.Q9),
    (at(State.Q9, counted=0.0), Reading(NOTHING, math.nan, FREE), State.Q0),
    (at(State.Q10, counted=0.0), Reading(NOTHING, math.nan, FREE), State.Q0),
]


@pytest.mark.parametrize(("memory", "reading", "after"), ROWS)
def test_each_row_of_table_1(memory, reading, after):
    assert step(memory, reading, SIZES, 0.0).state is after


def mirrored(state):
    pairs = {State.Q3: State.Q4, State.Q6: State.Q7, State.Q9: State.Q10}
    return {**pairs, **{b: a for a, b in pairs.items()}}.get(state, state)


distances = st.one_of(st.just(NOTHING), st.floats(0.3, 5.0))


@given(
    st.sampled_from([s for s in State if s is not State.Q2]),
    st.floats(0.5, 8.0),
    st.floats(-2.0, 2.0).filter(lambda x: abs(x) > 1e-6),
    st.tuples(distances, distances, distances, distances),
    st.booleans(),
)
def test_left_is_the_mirror_of_right(state, ahead, aside, d, rightwards):
    memory = at(state, rightwards=rightwards, since=-1.0, counted=0.5)
    other = at(mirrored(state), rightwards=not rightwards, since=-1.0, counted=0.5)
    seen = step(memory, Reading(ahead, aside, d), SIZES, 0.1)
    swapped = (d[2], d[3], d[0], d[1])
    back = step(other, Reading(ahead, -aside, swapped), SIZES, 0.1)
    if seen.nearest[1] != seen.nearest[3]:  # else the paper's q8 has no side either
        assert back.state is mirrored(seen.state)


def test_as_long_as_it_flew_aside_it_flies_back():
    memory, now, seen = Memory(), 0.0, []
    script = [
        (Reading(5.0, 0.0, FREE), 1), (Reading(2.0, 0.1, lasers(s1=2.0)), 10),
        (Reading(2.0, 0.5, FREE), 8), (Reading(NOTHING, math.nan, lasers(s2=1.0)), 10),
        (Reading(NOTHING, math.nan, FREE), 60),
    ]  # fmt: skip
    aside = 0.0
    for reading, times in script:
        for _ in range(times):
            now += 0.1
            memory = advance(memory, reading, SIZES, now)
            seen.append(memory.state)
            if memory.state is not State.Q0:
                aside += 0.1 * velocity(memory, SIZES)[1]
    order = [s for s, before in zip(seen, [None, *seen], strict=False) if s is not before]
    assert order == [State.Q1, State.Q3, State.Q5, State.Q6, State.Q8, State.Q9, State.Q0]
    assert aside == pytest.approx(0.0, abs=0.21)


def test_the_numbers_of_the_papers_sprayer():
    limits = Load(SPRAYER, 0.1).limits(Limits(speed=3.5, acceleration=3.0))
    found = numbers(AutomatonSettings(), limits, Load(SPRAYER, 0.1), 3.5)
    assert found.first_safe == pytest.approx(1.0 / math.tan(math.radians(25)))  # eq. 22
    assert found.corner == pytest.approx(0.5 * math.sin(math.radians(45)))
    seen = 1.0 - 0.5 * math.cos(math.radians(45)) - found.speed * AutomatonSettings().soonest
    stays = found.speed**2 / (math.sqrt(2) * 3.0)
    assert found.trigger == pytest.approx((seen - stays) / found.speed)  # eq. 29


@settings(deadline=None)
@given(st.floats(0.05, 2.0), st.floats(0.0, 1.0), st.floats(0.3, 1.2), st.floats(0.5, 4.0))
def test_the_trigger_time_ends_as_far_aside_as_was_asked(left, share, speed, most):
    """The bend from aside to ahead, each axis with its share of the acceleration (eq. 29)."""
    moving, rate = share * speed, most / math.sqrt(2)
    lasts = trigger_time(left, moving, speed, most)
    rising = min(lasts, (speed - moving) / rate)
    then = moving + rate * rising
    went = moving * rising + rate * rising**2 / 2 + speed * (lasts - rising)
    went += then**2 / (2 * rate)
    assert went >= left - 1e-9
    if lasts > 0:
        assert went == pytest.approx(left)


def test_a_side_laser_that_met_something_before_has_not_met_the_obstacle():
    before = at(State.Q5, rightwards=True, since=-1.0, nearest=met(s1=2.0, s2=4.0, s4=3.0))
    after = step(before, Reading(2.0, 0.4, FREE), SIZES, 0.0)
    assert after.state is State.Q6
    assert after.nearest == met(s1=2.0)
    assert step(after, Reading(NOTHING, math.nan, FREE), SIZES, 0.1).state is State.Q6


def scanned(known, points, now, yaw=0.0, tilt=0.0):
    """A radar at the origin reports `points` (n, 3) m of the site."""
    turn = from_yaw_pitch_roll(yaw, tilt)
    vehicle = VehicleState(
        now, np.zeros(3), np.zeros(3), turn, np.zeros(3),
        True, FlightMode.OFFBOARD, Landed.IN_AIR, now, 1.0, 16.0, True,
    )  # fmt: skip
    scan = RadarScan(now, np.empty((0, 4)), plant_protection_radar(0.2))
    known.take(np.array(points, dtype=float).reshape(-1, 3), scan, vehicle)
    return known.points


def test_what_the_radar_found_stands_until_it_looks_there_and_finds_nothing():
    known, pole = Reflections(), [[4.0, 0.2, 0.0]]
    for k in range(4):
        found = scanned(known, pole, 0.1 * k)
    np.testing.assert_allclose(found, pole)
    for k in range(300):  # turned away, or tilted up: nothing is seen, and nothing is forgotten
        assert len(scanned(known, [], 0.5 + 0.1 * k, yaw=1.5 if k % 2 else 0.0, tilt=-0.3)) == 1
    for k in range(25):  # looks there
        found = scanned(known, [], 31.0 + 0.1 * k)
    assert not len(found)


def test_a_ghost_is_not_remembered_and_a_nearer_look_replaces_a_farther_one():
    known = Reflections()
    scanned(known, [[6.0, 1.0, 0.0]], 0.0)
    assert not len(scanned(known, [], 0.1))
    for k in range(4):
        scanned(known, [[9.0, 0.0, 0.0]], 1.0 + 0.1 * k)
    known._range[:] = 20.0  # it was seen from there
    np.testing.assert_allclose(scanned(known, [[9.1, 0.2, 0.0]], 2.0), [[9.1, 0.2, 0.0]])


@given(st.floats(0.0, 1.0), st.floats(0.3, 6.0))
def test_heavier_means_slower_and_earlier(level, speed):
    asked = Limits(speed=speed, acceleration=3.0)
    settings = AutomatonSettings()
    light, heavy = Load(SPRAYER, level), Load(SPRAYER, 1.0)
    a = numbers(settings, light.limits(asked), light, speed)
    b = numbers(settings, heavy.limits(asked), heavy, speed)
    assert b.slowdown >= a.slowdown - 1e-6
    assert 0 < avoidance_speed(settings, heavy.limits(asked), heavy) <= speed


ROUTE = straight_route(40.0, speed=2.0)


@given(st.floats(2.0, 15.0), st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.floats(0.5, 3.0))
def test_a_velocity_command_joins_keeps_its_limits_and_ends_at_rest(now, vx, vy, most):
    wanted = np.array([vx, vy, 0.0])
    made = steered(ROUTE, (now, now + 0.3), wanted, most, 2.0)
    same_until(ROUTE, made, now, now + 0.3)
    after = np.linspace(now + 0.35, made.end, 200)
    _, _, accelerations = made.sample(after)
    begins = np.linalg.norm(ROUTE.at(now + 0.3).acceleration_site)
    assert np.linalg.norm(accelerations, axis=1).max() <= max(most, begins) + 1e-6
    rest = made.at(made.end)
    assert np.linalg.norm(rest.velocity_site) < 1e-9
    flown = made.sample(np.array([made.end - 2.0 - np.hypot(vx, vy) / most + 0.3]))[1][0]
    if np.hypot(vx, vy) > 0.2:
        assert flown == pytest.approx(wanted, abs=0.3 * np.hypot(vx, vy) + 0.05)


@pytest.mark.parametrize("aside", [-1.5, 0.0, 1.2])
@pytest.mark.parametrize("now", [5.0, 15.0, 19.0])
def test_the_way_back_ends_exactly_on_the_route_and_keeps_its_limits(aside, now):
    off = steered(ROUTE, (now, now + 0.3), np.array([0.5, aside, 0.0]), 2.0, 1.0)
    begin = now + 1.2
    way = back_to_route(off, ROUTE, (begin, begin + 0.3), begin, 2.0)
    assert way is not None
    same_until(off, way.trajectory, begin, begin + 0.3)
    for time in np.linspace(way.rejoin, way.trajectory.end, 20):
        want = ROUTE.at(time - way.delay)
        got = way.trajectory.at(time)
        np.testing.assert_allclose(got.position_site, want.position_site, atol=2e-3)
    _, _, accelerations = way.trajectory.sample(np.linspace(begin, way.trajectory.end, 400))
    assert np.linalg.norm(accelerations, axis=1).max() <= 2.0 * 1.05
    end = way.trajectory.at(way.trajectory.end)
    np.testing.assert_allclose(end.position_site, ROUTE.control_points_site[-1], atol=1e-9)


def test_settings_may_ask_for_a_wider_berth():
    load = Load(SPRAYER, 0.5)
    wide = replace(AutomatonSettings(), safe_arms=4.0)
    limits = load.limits(Limits(acceleration=3.0))
    assert numbers(wide, limits, load, 1.0).first_safe == pytest.approx(
        2 * numbers(AutomatonSettings(), limits, load, 1.0).first_safe
    )


POLES = {
    "ahead": [(12.0, 0.05, 0.2)],
    "on the left": [(12.0, 0.8, 0.2)],
    "thin, on the right": [(12.0, -0.3, 0.04)],
}
SHORT = straight_route(24.0, speed=2.0)
QUICK = Limits(speed=2.0, acceleration=2.0, clearance=0.85)


@pytest.mark.parametrize("name", POLES)
def test_passes_at_the_safe_distance_on_the_free_side_and_returns_to_the_line(name):
    flight = fly(Dfa(), SHORT, PoleMap(POLES[name]), limits=QUICK)
    assert flight.clearance(POLES[name]) >= QUICK.clearance
    assert "Stop" not in flight.kinds()
    np.testing.assert_allclose(flight.positions[-1], SHORT.control_points_site[-1], atol=0.05)
    assert flight.accelerations.max() <= 2.0 * 1.05
    aside = flight.positions[:, 1]
    assert np.abs(aside).max() < 2.2
    if name != "ahead":
        beside = aside[np.argmin(np.abs(flight.positions[:, 0] - 12.0))]
        assert np.sign(beside) == -np.sign(POLES[name][0][1])
    yaws = [v.yaw_site for _, v in flight.verdicts if isinstance(v, Avoid)]
    assert yaws == pytest.approx([0.0] * len(yaws), abs=1e-6)  # fixed heading


def test_stops_where_the_obstacle_has_no_end():
    fence = [(12.0, y, 0.15) for y in np.arange(-24, 24.1, 0.3)]
    flight = fly(Dfa(), SHORT, PoleMap(fence), limits=QUICK, longest=45.0)
    assert flight.kinds()[-1] in ("Stop", "Keep")
    assert "Stop" in flight.kinds()
    assert flight.clearance(fence) >= 0.5
    assert flight.positions[-1, 0] < 12.0


def test_stops_when_the_sensors_fall_silent():
    system = Dfa()
    verdict = system.plan(situation(15.0, 15.2, ROUTE, ROUTE, PoleMap([])))
    assert isinstance(verdict, Stop)
    assert "silent" in verdict.why


def test_eq_28_goes_through_what_was_measured():
    from orchard_cli.commands.identification import fit

    a, b, c, d = fit((0.0, 0.25, 0.5, 0.75, 1.0), (0.77, 0.77, 0.77, 0.75, 0.64))
    found = [a * math.exp(b * x) + c * math.exp(d * x) for x in (0.0, 0.5, 1.0)]
    assert found == pytest.approx([0.77, 0.77, 0.64], abs=0.02)


def test_a_stop_from_a_higher_speed_drifts_further():
    from orchard_cli.commands.identification import fly_test

    slow, fast = (fly_test(0.5, speed, 3.0).drift for speed in (0.5, 1.0))
    assert 0.25 < slow < fast < 1.0


def test_stopped_beside_the_route_it_stays_for_the_obstacle_may_stand_between():
    system, now = Dfa(), 10.0
    off = steered(ROUTE, (now, now + 0.3), np.array([0.0, 1.5, 0.0]), 2.0, 0.5)
    system._offered = off
    grid = PoleMap([])
    for _ in range(60):
        now += 0.1
        seen = situation(now, now + 0.3, off, ROUTE, grid, QUICK, poles=[])
        system._stop = off
        system._reference = ROUTE
        verdict = system.plan(seen)
        assert isinstance(verdict, Keep)
    assert "beside the route" in verdict.why


def test_what_stands_beyond_the_end_of_a_braking_trajectory_is_still_ahead():
    """A heavy sprayer slows down from so far that what it flies ends before the obstacle."""
    view, poles, forward = View(), [(20.0, 0.0, 0.2)], np.array([1.0, 0.0])
    active = steered(ROUTE, (5.0, 5.2), np.array([0.5, 0.0, 0.0]), 2.0, 0.5)
    for now in (5.3, 5.4, 5.5, 5.6, 5.7):
        seen = situation(now, now + 0.2, active, ROUTE, PoleMap([]), QUICK, poles=poles)
        view.look(seen)
    here = seen.vehicle.position_site
    assert active.at(active.end).position_site[0] < 15.0
    thing = view.obstacle(seen, 1.0, forward)
    assert thing is not None
    reading = view.reading(seen, 1.0, forward, thing)
    assert reading.ahead == pytest.approx(20.0 - 0.2 - here[0], abs=0.4)
