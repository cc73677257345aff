"""A position estimate that jumps: what is flown, and what is sent, does not."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.flight.anchored import Anchored
from orchard_cli.geometry.rotations import from_yaw_pitch_roll
from orchard_cli.model.vehicle import FlightMode, Landed, Pose, Setpoint, VehicleState

DT = 0.02
metres = st.floats(-8, 8)


class Drifting:
    """Flies a smooth curve; what it tells is off by `offset` and `turn`, which may change."""

    def __init__(self, armed=True):
        self.time = 0.0
        self.offset, self.turn = np.zeros(3), 0.0
        self.armed = armed
        self.told = []
        self.sent = []
        self.advance(0.0)

    def advance(self, dt):
        self.time += dt
        attitude = from_yaw_pitch_roll(0.3 * np.sin(self.time) + self.turn)
        self.told.append(Pose(self.time, self.truth() + self.offset, attitude))

    def truth(self):
        t = self.time
        return np.array([1.5 * t, 2.0 * np.sin(t / 2), 3.0 + 0.2 * np.cos(t)])

    def state(self):
        t, pose = self.time, self.told[-1]
        return VehicleState(
            pose.time, pose.position_site,
            np.array([1.5, np.cos(t / 2), -0.2 * np.sin(t)]), pose.site_from_body,
            np.array([0.0, 0.0, 0.3 * np.cos(t)]), self.armed, FlightMode.OFFBOARD,
            Landed.IN_AIR, pose.time, 0.9, 16.0, True,
        )  # fmt: skip

    def poses(self, since):
        return tuple(pose for pose in self.told if pose.time > since)

    def send(self, setpoint):
        self.sent.append(setpoint)


def setpoint(place):
    return Setpoint(0.0, np.array(place), np.zeros(3), np.zeros(3), 0.0)


def fly(far, steps, vehicle):
    for _ in range(steps):
        far.advance(DT)
        yield vehicle.state()


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(metres, metres, metres), min_size=1, max_size=4))
def test_offboard_setpoints_do_not_jump_when_the_estimator_resets(moves):
    far = Drifting()
    vehicle = Anchored(far)
    vehicle.state()
    place = far.truth() + np.array([0.3, 0.0, 0.0])
    for move in moves:
        for state in fly(far, 10, vehicle):
            assert state.position_site == pytest.approx(far.truth(), abs=0.31 * len(moves))
        far.offset = far.offset + move
        far.advance(DT)
        state = vehicle.state()
        vehicle.send(setpoint(place))
        error_site = place - state.position_site
        error_told = far.sent[-1].position_site - far.state().position_site
        assert error_told == pytest.approx(error_site, abs=1e-9)
    big = [m for m in moves if np.linalg.norm(m) > 0.35]
    assert len(vehicle.jumps()) >= len(big)


def test_a_flight_without_jumps_is_told_as_it_is_and_has_none():
    far = Drifting()
    vehicle = Anchored(far)
    for state in fly(far, 500, vehicle):
        assert state.position_site == pytest.approx(far.truth(), abs=1e-12)
    assert vehicle.jumps() == ()
    assert not vehicle.shift_site.any()


def test_after_silence_only_what_no_manoeuvre_explains_is_a_jump():
    far = Drifting()
    vehicle = Anchored(far)
    vehicle.state()
    far.advance(1.0)
    vehicle.state()
    assert vehicle.jumps() == ()
    far.offset = np.array([9.0, 0.0, 0.0])
    far.advance(1.0)
    vehicle.state()
    assert len(vehicle.jumps()) == 1


def test_on_the_ground_before_arming_the_coordinates_are_taken_as_they_are():
    far = Drifting(armed=False)
    vehicle = Anchored(far)
    vehicle.state()
    far.offset = np.array([5.0, 0.0, 0.6])
    far.advance(DT)
    assert vehicle.state().position_site == pytest.approx(far.truth() + far.offset)
    assert vehicle.jumps() == ()


def test_a_heading_that_jumps_is_told_and_moves_nothing():
    far = Drifting()
    vehicle = Anchored(far)
    vehicle.state()
    far.turn = 0.8
    far.advance(DT)
    assert vehicle.state().position_site == pytest.approx(far.truth())
    (jump,) = vehicle.jumps()
    assert jump.turned == pytest.approx(0.8, abs=0.02)
    assert "+46 degrees" in str(jump)


def test_poses_before_and_after_a_jump_lie_on_one_curve():
    far = Drifting()
    vehicle = Anchored(far)
    for k, _ in enumerate(fly(far, 40, vehicle)):
        if k == 20:
            far.offset = np.array([2.0, -1.0, 0.5])
    places = np.array([pose.position_site for pose in vehicle.poses(0.0)])
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() < 0.05


def test_an_autopilot_that_reboots_begins_anew():
    far = Drifting()
    vehicle = Anchored(far)
    list(fly(far, 20, vehicle))
    far.told, far.time = [], 0.0
    far.offset = np.array([50.0, 0.0, 0.0])
    far.advance(DT)
    vehicle.state()
    assert vehicle.jumps() == ()
    assert len(vehicle.poses(0.0)) == 1


def test_all_but_the_position_of_a_setpoint_is_sent_as_it_is():
    far = Drifting()
    vehicle = Anchored(far)
    wanted = setpoint([1.0, 2.0, 3.0])
    vehicle.send(wanted)
    assert dataclasses.asdict(far.sent[0]).keys() == dataclasses.asdict(wanted).keys()
    assert far.sent[0].position_site == pytest.approx([1.0, 2.0, 3.0])
