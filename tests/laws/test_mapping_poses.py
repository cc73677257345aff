"""Rotations agree with scipy's, and a frame's pose is found between the poses around it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from orchard_cli.geometry import rotations
from orchard_cli.geometry.poses import interpolate
from orchard_cli.model.vehicle import Pose

angle = st.floats(-3.1, 3.1)
turns = st.builds(rotations.from_yaw_pitch_roll, angle, st.floats(-1.5, 1.5), angle)


def scipys(q):
    return Rotation.from_quat([q[1], q[2], q[3], q[0]])


@given(angle, st.floats(-1.5, 1.5), angle)
def test_yaw_pitch_roll_turn_as_scipys_do(yaw, pitch, roll):
    ours = rotations.matrix(rotations.from_yaw_pitch_roll(yaw, pitch, roll))
    np.testing.assert_allclose(
        ours, Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix(), atol=1e-12
    )


@given(turns, turns)
def test_products_and_inverses_turn_as_scipys_do(a, b):
    np.testing.assert_allclose(
        rotations.matrix(rotations.multiply(a, rotations.inverse(b))),
        (scipys(a) * scipys(b).inv()).as_matrix(), atol=1e-12,
    )  # fmt: skip
    vectors = np.array([[1.0, 2.0, 3.0], [0.0, -1.0, 0.5]])
    np.testing.assert_allclose(rotations.rotate(a, vectors), scipys(a).apply(vectors), atol=1e-12)


def test_positive_yaw_turns_the_nose_left_and_positive_pitch_lowers_it():
    nose = np.array([1.0, 0.0, 0.0])
    assert rotations.rotate(rotations.from_yaw_pitch_roll(0.1), nose)[1] > 0
    assert rotations.rotate(rotations.from_yaw_pitch_roll(0.0, 0.1), nose)[2] < 0
    left = np.array([0.0, 1.0, 0.0])
    assert rotations.rotate(rotations.from_yaw_pitch_roll(0.0, 0.0, 0.1), left)[2] > 0


@given(turns, turns, st.floats(0, 1), st.booleans())
def test_slerp_goes_the_short_way_as_scipys_does(a, b, share, flip):
    ours = rotations.slerp(a, -b if flip else b, share)
    theirs = Slerp([0, 1], Rotation.concatenate([scipys(a), scipys(b)]))(share)
    if (scipys(a).inv() * scipys(b)).magnitude() < 3.1:  # half a turn has two short ways
        assert (scipys(ours).inv() * theirs).magnitude() < 1e-6


def test_a_quaternion_without_length_is_refused():
    for bad in (np.zeros(4), np.array([np.nan, 0, 0, 0])):
        with pytest.raises(ValueError, match="length"):
            rotations.normalised(bad)


def flown(times):
    return [
        Pose(t, np.array([t, 2 * t, -t]), rotations.from_yaw_pitch_roll(0.3 * t)) for t in times
    ]


@settings(max_examples=50)
@given(st.lists(st.integers(0, 200), min_size=2, max_size=10, unique=True), st.floats(0, 1))
def test_between_its_neighbours_a_pose_lies_on_a_steady_motion(ticks, share):
    times = sorted(tick / 50 for tick in ticks)
    time = times[0] + share * (times[-1] - times[0])
    pose = interpolate(flown(times), time)
    assert pose.time == time
    np.testing.assert_allclose(pose.position_site, [time, 2 * time, -time], atol=1e-9)
    want = rotations.from_yaw_pitch_roll(0.3 * time)
    np.testing.assert_allclose(pose.site_from_body, want, atol=1e-9)


def test_no_pose_is_guessed_outside_what_was_measured():
    poses = flown([1.0, 1.1])
    assert interpolate(poses, 0.9) is None
    assert interpolate(poses, 1.15) is None
    assert interpolate([], 1.0) is None
    np.testing.assert_array_equal(interpolate(poses, 1.11).position_site, poses[1].position_site)
    np.testing.assert_array_equal(interpolate(poses, 0.99).position_site, poses[0].position_site)
