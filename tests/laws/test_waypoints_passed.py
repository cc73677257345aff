"""A waypoint that an avoidance leaves out is told in flight, and counted afterwards."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from orchard_cli.analysis.figures import Unknown
from orchard_cli.analysis.stream import setpoint_jitter, waypoints_missed
from orchard_cli.flight.passage import Passage
from orchard_cli.model.trajectory import Trajectory

WAYPOINTS = np.array([[0.0, 0.0, 3.0], [10.0, 0.0, 3.0], [10.0, 6.0, 3.0], [0.0, 6.0, 3.0]])
MISSION = SimpleNamespace(waypoints_site=WAYPOINTS)


def along(*corners):
    """At 1 m/s from corner to corner, from time 0."""
    points = [np.array(corners[0], dtype=float)] * 2
    for a, b in pairwise(corners):
        steps = int(np.linalg.norm(np.subtract(b, a)) / 0.5)
        points += [np.add(a, np.subtract(b, a) * k / steps) for k in range(steps + 1)]
    return Trajectory(0.0, 0.5, np.column_stack([points, np.full(len(points), 3.0)]))


ROUTE = along((0, 0), (10, 0), (10, 6), (0, 6))


def missed(waypoints, way):
    passage = Passage(waypoints)
    places = way.sample(np.arange(0.0, way.end, 0.1))[0]
    return [*(number for place in places for number in passage.missed(place)), *passage.rest()]


def test_only_a_waypoint_that_is_truly_left_out_is_told_and_once():
    assert missed(WAYPOINTS, ROUTE) == []
    assert missed(WAYPOINTS, along((0, 0), (9, -1.2), (11, 4), (10, 6), (0, 6))) == []
    assert missed(WAYPOINTS, along((0, 0), (7, 0), (7.5, 4), (10, 6), (0, 6))) == [2]
    assert missed(WAYPOINTS, along((0, 0), (6, 0), (6, 6), (0, 6))) == [2, 3]


def test_an_aside_that_comes_back_leaves_nothing_out():
    aside = along((0, 0), (4, 0), (4, 3), (6, 3), (6, 0), (10, 0), (10, 6), (0, 6))
    assert missed(WAYPOINTS, aside) == []


def test_rows_so_close_that_the_next_ones_end_is_within_reach_leave_nothing_out():
    close = np.array([[0, 0, 3], [10, 0, 3], [10, 1.5, 3], [0, 1.5, 3], [0, 3, 3], [10, 3, 3.0]])
    assert missed(close, along(*close[:, :2])) == []


@pytest.mark.parametrize(("way", "missed"), [(ROUTE, 0), (along((0, 0), (6, 0), (0, 6)), 2)])
def test_the_flown_route_counts_the_waypoints_it_did_not_pass(way, missed):
    places = way.sample(np.arange(0.0, way.end, 0.1))[0]
    assert waypoints_missed(SimpleNamespace(positions_site=places), MISSION) == missed


def test_jitter_is_of_the_pace_and_pauses_are_none():
    times = np.concatenate([np.arange(200), 200 + 60 + np.arange(200)]) * 0.02
    assert setpoint_jitter(times) == pytest.approx(0.0, abs=1e-6)
    late = times + np.where(np.arange(400) % 2, 0.004, 0.0)
    assert setpoint_jitter(late) == pytest.approx(4.0, abs=1e-6)
    assert isinstance(setpoint_jitter(times[:50]), Unknown)
