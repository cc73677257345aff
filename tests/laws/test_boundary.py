"""Fence and keep-outs in flight: one judgement for every avoidance system."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.flight.boundary import NO_EDGE, bounded, margins
from orchard_cli.geometry.area import Area
from orchard_cli.model.mission import Limits
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.motion.situation import Avoid, Keep, Stop
from tests.laws.test_safety import vehicle

FENCE = np.array([[-5.0, -5.0], [25.0, -5.0], [25.0, 5.0], [-5.0, 5.0]])
HOLE = np.array([[10.0, 1.0], [12.0, 1.0], [12.0, 3.0], [10.0, 3.0]])
AREA = Area(FENCE, (HOLE,))
metres = st.floats(-30, 30)


def line(bulge=0.0, end=20.0):
    """Along x at 1 m/s from x = 0 at time 0; `bulge` m to the left around x = 11."""
    x = np.arange(-1, int(end / 0.5) + 2) * 0.5
    y = bulge * np.exp(-(((x - 11.0) / 2.0) ** 2))
    return Trajectory(0.0, 0.5, np.column_stack([x, y, np.full_like(x, 3.0)]))


def avoid(way, rejoin=16.0):
    return Avoid(way, begin=5.0, rejoin=rejoin, why="round it", blocked_at=4.0)


@given(metres, metres)
def test_margins_are_distances_with_the_sign_of_what_is_allowed(x, y):
    def box(low, high):
        out = np.maximum(np.maximum(low - [x, y], [x, y] - high), 0.0)
        inside = np.minimum([x, y] - low, high - [x, y]).min()
        return inside if inside > 0 else -float(np.hypot(*out))

    expected = min(box(FENCE[0], FENCE[2]), -box(HOLE[0], HOLE[2]))
    assert AREA.margins(np.array([[x, y]]))[0] == pytest.approx(expected, abs=1e-9)


def test_without_fence_and_keep_outs_everything_is_allowed():
    everywhere = Area(np.empty((0, 2)))
    assert everywhere.unbounded
    assert margins(everywhere, vehicle(), np.zeros(3), 0.5) is NO_EDGE
    assert everywhere.leaves(np.array([[1e9, 1e9]]), 1.0) is None
    keep = Keep()
    assert bounded(keep, line(), 0.0, 0.3, everywhere, Limits()) is keep


@pytest.mark.parametrize("bulge", [2.0, 4.9, 7.0, -4.9, -6.0])
def test_an_avoidance_that_leaves_the_fence_or_enters_a_keep_out_is_refused(bulge):
    verdict = bounded(avoid(line(bulge)), line(), 5.0, 5.3, AREA, Limits())
    assert isinstance(verdict, Stop)
    places = verdict.trajectory.sample(np.linspace(5.0, verdict.trajectory.end, 50))[0]
    assert AREA.margins(places).min() > Limits().airframe_radius
    assert verdict.trajectory.at(verdict.trajectory.end).velocity_site == pytest.approx(np.zeros(3))


@pytest.mark.parametrize("bulge", [0.3, -2.0, -4.0])
def test_an_avoidance_that_stays_inside_is_flown(bulge):
    verdict = avoid(line(bulge))
    assert bounded(verdict, line(), 5.0, 5.3, AREA, Limits()) is verdict


def test_what_is_flown_already_is_stopped_before_the_edge():
    away = line(end=40.0)
    verdict = bounded(Keep(), away, 18.0, 18.3, AREA, Limits())
    assert isinstance(verdict, Stop)
    assert verdict.trajectory.control_points_site[-1, 0] < 25.0
    assert verdict.blocked_at == pytest.approx(25.0 - 18.0 - 0.3, abs=0.2)


@settings(max_examples=50)
@given(st.floats(-4.9, -4.7), st.floats(0.3, 2.0))
def test_a_vehicle_that_stands_too_near_the_edge_may_fly_inwards(y, inwards):
    way = np.array([[0.0, y], [0.0, y + inwards], [5.0, y + inwards]])
    assert AREA.leaves(way, 0.35) is None
    assert AREA.leaves(way * [1, -1] + [0, 2 * y], 0.35) == 1


def test_where_full_braking_ends_is_judged_and_where_the_autopilot_believes_to_be():
    fast = vehicle(position_site=np.array([23.5, 0, 3]), velocity_site=np.array([1.5, 0, 0]))
    found = margins(AREA, fast, np.zeros(3), 0.5)
    assert found.here == pytest.approx(1.5)
    assert found.ahead == pytest.approx(1.5 - 2.25)
    moved = margins(AREA, fast, np.array([-2.0, 0.0, 0.0]), 0.5)  # it believes to be at 25.5
    assert moved.here == pytest.approx(-0.5)
