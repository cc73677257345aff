"""Site frame <-> the autopilot's NED: every sign."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchard_cli.geometry.rotations import rotate
from orchard_cli.vehicle.frames import LocalFrame, flu_from_frd

headings = st.floats(-np.pi, 2 * np.pi)
coordinates = st.tuples(*[st.floats(-500, 500)] * 3).map(np.array)
ORIGIN = np.array([3.0, -7.0, 0.0])


@given(headings, coordinates)
def test_positions_come_back_from_ned(heading, position):
    frame = LocalFrame(heading, ORIGIN)
    assert frame.position_site(frame.position_ned(position)) == pytest.approx(position, abs=1e-9)


def test_x_points_along_the_heading_y_to_its_left_and_z_up():
    north = LocalFrame(0.0, np.zeros(3))
    assert north.vector_ned(np.array([1.0, 0, 0])) == pytest.approx([1, 0, 0])
    assert north.vector_ned(np.array([0, 1.0, 0])) == pytest.approx([0, -1, 0])  # left is west
    assert north.vector_ned(np.array([0, 0, 1.0])) == pytest.approx([0, 0, -1])
    east = LocalFrame(np.pi / 2, np.zeros(3))
    assert east.vector_ned(np.array([1.0, 0, 0])) == pytest.approx([0, 1, 0])
    assert east.vector_ned(np.array([0, 1.0, 0])) == pytest.approx([1, 0, 0])  # left is north


@given(headings, st.floats(-np.pi, np.pi))
def test_the_nose_points_where_yaw_says_in_both_frames(heading, yaw_site):
    frame = LocalFrame(heading, np.zeros(3))
    yaw_ned = frame.yaw_ned(yaw_site)
    nose_site = frame.vector_site(np.array([np.cos(yaw_ned), np.sin(yaw_ned), 0.0]))
    assert nose_site == pytest.approx([np.cos(yaw_site), np.sin(yaw_site), 0.0], abs=1e-9)


@given(headings, st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1))
def test_attitude_turns_body_vectors_alike_in_both_frames(heading, values):
    ned_from_frd = np.array(values) / np.linalg.norm(values)
    frame = LocalFrame(heading, np.zeros(3))
    body_flu = np.array([[1.0, 2.0, 3.0]])
    body_frd = body_flu * [1, -1, -1]
    by_ned = frame.vector_site(rotate(ned_from_frd, body_frd)[0])
    by_site = rotate(frame.site_from_body(ned_from_frd), body_flu)[0]
    assert by_site == pytest.approx(by_ned, abs=1e-9)


def test_rates_keep_roll_and_flip_pitch_and_yaw():
    assert flu_from_frd(np.array([1.0, 2.0, 3.0])) == pytest.approx([1, -2, -3])
