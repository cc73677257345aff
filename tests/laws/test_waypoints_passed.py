"""A waypoint that an avoidance leaves out is told in flight, and counted afterwards."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from orchard_cli.analysis.figures import Unknown
from orchard_cli.analysis.stream import setpoint_jitter, waypoints_missed
from orchard_cli.flight.skipped import skipped
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


def test_a_missed_waypoint_is_named_when_the_way_round_is_taken():
    short = along((0, 0), (6, 0), (6, 6), (0, 6))
    beside = along((0, 0), (9, -1.2), (11, 4), (10, 6), (0, 6))
    assert skipped(MISSION, ROUTE, short, 3.0) == (2, 3)
    assert skipped(MISSION, ROUTE, beside, 3.0) == ()
    assert skipped(MISSION, ROUTE, ROUTE, 3.0) == ()


def test_waypoints_that_lie_behind_are_not_missed():
    assert skipped(MISSION, ROUTE, along((10, 6), (0, 6)).shifted(17.0), 17.0) == ()


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
