"""Setpoints never step: standing, joining, following, braking, turning."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchard_cli.flight.guidance import Guidance
from orchard_cli.model.mission import Limits
from orchard_cli.motion.yaw import PUBLISHED, STEADY, YAW_ACCELERATION, step_yaw, wrapped

from .test_safety import vehicle

LIMITS = Limits()
DT = 0.02
ROUTE = np.array([[0.0, 0, 3], [0, 12, 3]])


def fly(guidance, start, seconds, each=lambda now: None):
    setpoints = []
    for k in range(int(seconds / DT)):
        now = start + k * DT
        each(now)
        setpoints.append(guidance.setpoint(now))
    return setpoints


def steps(setpoints):
    positions = np.array([s.position_site for s in setpoints])
    velocities = np.array([s.velocity_site for s in setpoints])
    yaws = np.unwrap([s.yaw_site for s in setpoints])
    rates = np.diff(yaws) / DT
    return (
        np.linalg.norm(np.diff(positions, axis=0), axis=1).max(),
        np.linalg.norm(np.diff(velocities, axis=0), axis=1).max(),
        np.abs(rates).max(),
        np.abs(np.diff(rates)).max(),
    )


def test_from_hover_to_route_to_brake_nothing_steps():
    guidance = Guidance(LIMITS)
    guidance.stand(vehicle(position_site=np.array([0.6, -0.8, 3.1])))
    guidance.join(guidance.timed(ROUTE), 0.0)
    events = []

    def act(now):
        guidance.advance(now)
        if guidance.pending and guidance.joined(now):
            guidance.begin(now)
            events.append(now)
        if events and not guidance.pending and now > events[0] + 5 and len(events) == 1:
            guidance.brake(now)
            events.append(now)

    flown = fly(guidance, 0.0, 30.0, act)
    assert len(events) == 2
    position, velocity, rate, change = steps(flown)
    assert position <= 1.02 * LIMITS.speed * DT
    assert velocity <= 1.05 * LIMITS.acceleration * DT
    assert rate <= LIMITS.yaw_rate + 1e-9
    assert change <= YAW_ACCELERATION * DT + 1e-9
    assert np.linalg.norm(flown[-1].velocity_site) == 0
    assert flown[-1].position_site[1] < 8


def test_it_looks_along_the_route_before_it_begins():
    guidance = Guidance(LIMITS)
    guidance.stand(vehicle(position_site=np.array([0.0, 0.0, 3.0])))
    guidance.join(guidance.timed(ROUTE), 0.0)
    assert not guidance.joined(0.0)
    fly(guidance, 0.0, 5.0)
    assert guidance.joined(5.0)
    assert guidance.setpoint(5.0).yaw_site == pytest.approx(math.pi / 2, abs=0.08)


def test_a_route_that_was_flown_has_arrived_but_not_before():
    guidance = Guidance(LIMITS)
    guidance.stand(vehicle(position_site=np.array([0.0, 0.0, 3.0])))
    assert not guidance.arrived(0.0)
    guidance.join(guidance.timed(ROUTE), 0.0)
    assert not guidance.arrived(0.0)
    route = guidance.begin(1.0)
    assert not guidance.arrived(route.end - 0.1)
    assert guidance.arrived(route.end)


@given(st.floats(-math.pi, math.pi), st.floats(-0.8, 0.8), st.floats(-math.pi, math.pi))
def test_yaw_settles_on_its_target_without_overshoot(yaw, rate, target):
    for _ in range(1500):
        yaw, rate = step_yaw(yaw, rate, target, DT, 0.8, 1.0)
        assert abs(rate) <= 0.8
    assert wrapped(target - yaw) == pytest.approx(0, abs=1e-3)
    assert abs(rate) < 1e-3


def test_the_published_yaw_turns_at_half_its_rate_and_at_all_of_it_across_the_wrap():
    """EGO.md: the limited change, averaged with the yaw before; not where it crosses ±π."""
    yaw, rate, turned = 0.0, 0.0, []
    for _ in range(30):
        yaw, rate = PUBLISHED.turn(yaw, rate, 3.0, DT, 0.8)
        turned.append(yaw)
    assert np.diff(turned)[:20] == pytest.approx(math.pi / 2 * DT)
    assert rate == pytest.approx(math.pi, rel=0.01)
    yaw, _ = PUBLISHED.turn(3.13, 0.0, -3.0, DT, 0.8)
    assert wrapped(yaw - 3.13) == pytest.approx(math.pi * DT)


def test_the_yaw_rule_says_how_far_ahead_the_nose_looks():
    flown = {}
    for rule in (STEADY, PUBLISHED):
        guidance = Guidance(LIMITS, rule)
        guidance.stand(vehicle(position_site=np.array([0.0, 0.0, 3.0])))
        path = np.array([[0.0, 0, 3], [8, 0, 3], [8, 8, 3]])
        guidance.join(guidance.timed(path), 0.0)
        fly(guidance, 0.0, 2.0, guidance.advance)
        guidance.begin(2.0)
        flown[rule.ahead] = np.array([s.yaw_site for s in fly(guidance, 2.0, 25.0)])
    assert np.argmax(flown[2.0] > 0.3) < np.argmax(flown[1.0] > 0.3)
    assert np.abs(np.diff(flown[1.0])).max() / DT > LIMITS.yaw_rate
    assert np.abs(np.diff(flown[2.0])).max() / DT <= LIMITS.yaw_rate + 1e-9
