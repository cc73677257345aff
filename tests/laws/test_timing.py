"""The time law: every limit kept everywhere, rest at both ends, the path followed, no time lost."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.motion.fit import distances, lengths_of, rounded
from orchard_cli.motion.timing import TOLERANCE, PathLimits, over_limits, peaks, time_path

LIMITS = PathLimits(1.0, 0.5, 0.27, 0.8, 0.7)

limits = st.builds(
    PathLimits,
    speed=st.floats(0.3, 4),
    acceleration=st.floats(0.2, 3),
    acceleration_along=st.floats(0.1, 2),
    yaw_rate=st.floats(0.2, 2),
    climb_speed=st.floats(0.3, 2),
)


@st.composite
def paths(draw):
    """Smooth paths in space with turns of up to 150 degrees."""
    heading, points = 0.0, [np.zeros(3)]
    for _ in range(draw(st.integers(1, 5))):
        step, slope = draw(st.floats(2, 20)), draw(st.floats(-0.3, 0.3))
        points.append(points[-1] + step * np.array([np.cos(heading), np.sin(heading), slope]))
        heading += draw(st.floats(-2.6, 2.6))
    return rounded(np.array(points), 0.5).points_site


def dense(trajectory):
    return trajectory.sample(np.linspace(trajectory.start, trajectory.end, 4001))


@given(paths(), limits)
@settings(max_examples=25, deadline=None, derandomize=True)
def test_every_limit_is_kept_everywhere(path, limits):
    trajectory = time_path(path, limits).trajectory
    _, v, a = dense(trajectory)
    speed = np.linalg.norm(v, axis=1)
    flat = np.hypot(v[:, 0], v[:, 1])
    turn = np.abs(v[:, 0] * a[:, 1] - v[:, 1] * a[:, 0])[flat > 0.06] / flat[flat > 0.06] ** 2
    most = 1 + TOLERANCE
    assert speed.max() <= most * limits.speed
    assert np.linalg.norm(a, axis=1).max() <= most * limits.acceleration
    along = np.abs((v * a).sum(axis=1)) / np.maximum(speed, 1e-6)
    assert along.max() <= most * limits.acceleration_along
    assert turn.max(initial=0) <= most * limits.yaw_rate
    assert np.abs(v[:, 2]).max() <= most * limits.climb_speed


@given(paths(), limits)
@settings(max_examples=25, deadline=None, derandomize=True)
def test_it_starts_and_ends_at_rest_on_the_path_ends(path, limits):
    trajectory = time_path(path, limits).trajectory
    for time, end in ((trajectory.start, path[0]), (trajectory.end, path[-1])):
        p, v, a = (x[0] for x in trajectory.sample(np.array([time])))
        assert p == pytest.approx(end, abs=1e-6)
        assert np.abs(v).max() < 1e-9
        assert np.abs(a).max() < 1e-9


@given(paths(), st.floats(0.5, 2))
@settings(max_examples=25, deadline=None, derandomize=True)
def test_it_stays_within_two_centimetres_of_a_smooth_path(path, speed):
    trajectory = time_path(path, dataclasses.replace(LIMITS, speed=speed)).trajectory
    flown = dense(trajectory)[0]
    assert distances(flown[::20], path).max() < 0.02


@given(paths())
@settings(max_examples=20, deadline=None, derandomize=True)
def test_time_at_tells_where_the_trajectory_is(path):
    timed = time_path(path, LIMITS)
    lengths = lengths_of(path)
    for share in (0.1, 0.5, 0.9):
        there = [np.interp(share * lengths[-1], lengths, axis) for axis in path.T]
        here = timed.trajectory.at(timed.time_at(share * lengths[-1])).position_site
        assert np.linalg.norm(here - there) < 0.03


def test_a_straight_takes_little_more_than_the_fastest_time():
    """50 m at 1 m/s and 0.27 m/s²: 50 + 1 / 0.27 s; the easing and the standing cost 1 s each."""
    trajectory = time_path(np.array([[0.0, 0, 3], [50, 0, 3]]), LIMITS).trajectory
    assert 50 + 1 / 0.27 < trajectory.end < 50 + 1 / 0.27 + 4.0


def test_acceleration_changes_no_faster_than_the_easing_lets_it():
    trajectory = time_path(np.array([[0.0, 0, 3], [20, 0, 3]]), LIMITS).trajectory
    times = np.linspace(0, trajectory.end, 5001)
    jerk = np.abs(np.diff(trajectory.sample(times)[2], axis=0)).max() / times[1]
    assert jerk < 2 * LIMITS.acceleration_along / 1.0


@pytest.mark.parametrize(
    "corners",
    [
        [[0, 0, 3], [10, 0, 3], [10, 10, 3]],
        [[0, 0, 3], [10, 0, 3], [2, 2, 3]],
        [[0, 0, 3], [5, 0, 3], [0, 0, 3]],
        [[0, 0, 0], [0, 0, 5], [5, 0, 5]],
        [[0, 0, 0], [0.01, 0, 0]],
        [[i, (i % 2) * 0.5, 2] for i in range(12)],
    ],
)
def test_sharp_corners_are_crept_round_within_two_centimetres(corners):
    path = np.array(corners, dtype=float)
    trajectory = time_path(path, LIMITS).trajectory
    over = over_limits(trajectory, LIMITS)
    del over["yaw_rate"]  # of a path that turns at a point there is none
    assert max(over.values()) <= 1 + TOLERANCE
    assert distances(dense(trajectory)[0][::8], path).max() < 0.02


def test_interval_is_half_a_metre_of_cruise_unless_told():
    path = np.array([[0.0, 0, 3], [20, 0, 3]])
    assert time_path(path, LIMITS).trajectory.interval == 0.5
    assert time_path(path, LIMITS, interval=0.2).trajectory.interval == 0.2


def test_peaks_are_those_of_the_curve():
    trajectory = time_path(np.array([[0.0, 0, 0], [20, 0, 0], [20, 0, 8]]), LIMITS).trajectory
    p = peaks(trajectory)
    _, v, a = dense(trajectory)
    assert p.speed == pytest.approx(np.linalg.norm(v, axis=1).max(), rel=1e-3)
    assert p.acceleration == pytest.approx(np.linalg.norm(a, axis=1).max(), rel=1e-2)
    assert p.climb_speed == pytest.approx(0.7, rel=0.01)


@pytest.mark.parametrize("name", [f.name for f in dataclasses.fields(PathLimits)])
def test_limits_that_are_not_positive_are_refused(name):
    with pytest.raises(ValueError, match=name):
        time_path(np.eye(3), dataclasses.replace(LIMITS, **{name: 0.0}))


def test_a_path_without_length_is_refused():
    with pytest.raises(ValueError, match="length"):
        time_path(np.ones((5, 3)), LIMITS)
