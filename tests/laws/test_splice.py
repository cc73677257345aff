"""Replacing a span: the head is kept, the tail is the reference, later."""

import numpy as np
import pytest

from orchard_cli.mapping import Band, distance_field
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.motion.pacing import pace
from orchard_cli.motion.rejoin import Stretch, choose_rejoin
from orchard_cli.motion.splice import counterpart, head_at, knots_of, shared_tail, splice
from orchard_cli.motion.subdivision import controls_of, knot_state, refined

from ..pole_world import same_until, straight_route

ROUTE = straight_route(30.0)


def spliced(commit=10.2, rejoin=45, count=24):
    head = head_at(ROUTE, commit, ROUTE.interval)
    a, b = head.control_points_site[-1], ROUTE.control_points_site[rejoin]
    free = np.linspace(a, b, count + 2)[1:-1] + np.array([0, 1.0, 0])
    return head, splice(head, free, ROUTE, rejoin)


def test_joins_keep_position_velocity_and_acceleration():
    head, flown = spliced()
    assert head.begin == pytest.approx(10.5)
    same_until(ROUTE, flown, 0.0, head.begin)
    delay = (len(flown.control_points_site) - len(ROUTE.control_points_site)) * ROUTE.interval
    for t in np.linspace(45 * 0.5, ROUTE.end, 9):
        a, b = ROUTE.at(t), flown.at(t + delay)
        np.testing.assert_allclose(a.position_site, b.position_site, atol=1e-9)
        np.testing.assert_allclose(a.velocity_site, b.velocity_site, atol=1e-9)


def test_the_tail_is_found_again_and_its_knots_are_matched():
    head, flown = spliced()
    tail = shared_tail(flown, ROUTE)
    assert tail == len(ROUTE.control_points_site) - 45
    delay = len(flown.control_points_site) - len(ROUTE.control_points_site)
    knots = knots_of(flown.control_points_site)
    assert counterpart(flown, ROUTE, tail, 50 + delay, knots[50 + delay]) == 50
    middle = len(head.control_points_site) + 10
    beside = counterpart(flown, ROUTE, tail, middle, knots[middle])
    reference = knots_of(ROUTE.control_points_site)
    assert abs(reference[beside][0] - knots[middle][0]) <= 0.26


def test_an_unchanged_trajectory_shares_everything():
    assert shared_tail(ROUTE, ROUTE) == len(ROUTE.control_points_site)


def test_past_its_end_the_head_stands_still():
    head = head_at(ROUTE, ROUTE.end + 3.0, 0.5)
    assert head.begin == ROUTE.end + 3.0
    assert (head.control_points_site == ROUTE.control_points_site[-1]).all()
    soon = head_at(ROUTE, ROUTE.end + 0.3, 0.5)
    assert soon.begin >= ROUTE.end + 0.3
    same_until(ROUTE, Trajectory(soon.start, soon.interval, soon.control_points_site), 30.0, 99.0)


def test_other_intervals_are_not_mixed():
    other = Trajectory(0.0, 0.25, ROUTE.control_points_site)
    with pytest.raises(ValueError, match="intervals"):
        splice(head_at(other, 3.0, 0.5), np.zeros((2, 3)), ROUTE, 45)


def test_a_guide_is_sampled_evenly_at_constant_speed():
    """Liu 2024, §4.3: the points are evenly sampled on the guide path."""
    guide = np.array([[0.0, 0.0], [4.0, 1.0], [9.0, 0.0]])
    line = np.column_stack([np.linspace(0, 9, 19), np.zeros(19), np.zeros(19)])
    points = pace(guide, line, 0.5, 0.5, (1.0, 1.0), 1.0, 0.3)
    np.testing.assert_allclose(points[[0, -1]], guide[[0, -1]])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert np.ptp(steps) < 0.02
    assert steps.max() < 0.51


def test_from_rest_the_sampling_speeds_up_within_the_acceleration():
    guide = np.array([[0.0, 0.0], [9.0, 0.0]])
    line = np.column_stack([np.linspace(0, 9, 19), np.zeros(19), np.zeros(19)])
    points = pace(guide, line, 0.5, 0.5, (0.0, 1.0), 1.0, 0.3)
    speeds = np.diff(points[:, 0]) / 0.5
    assert speeds[0] < 0.3
    assert np.diff(speeds).max() / 0.5 < 0.4
    assert speeds.max() < 1.02


def stretch(occupied_x, conflict, ends=False, corner=np.inf):
    """A reference along x, 0.5 m between its knots, that turns left at `corner`; 1 m kept clear."""
    s = np.arange(0, 20, 0.5)
    knots = np.column_stack([np.minimum(s, corner), np.maximum(s - corner, 0.0), 0 * s])
    occupied = np.zeros((220, 220), dtype=bool)
    for x in occupied_x:
        occupied[int((x + 1) / 0.1), 10] = True
    band = Band(np.array([-1.0, -1.0]), 0.1, occupied, np.ones_like(occupied), 3.0, 4.0)
    return Stretch.of(knots, np.array(conflict), distance_field(band, 1.8), 1.0, ends)


def test_rejoins_behind_the_obstacle_where_the_reference_is_free_again():
    two = stretch([5.05, 9.05], [4.0, 0.0])
    assert two.lengths[choose_rejoin(two, 1.0, 0.5).knot] == 7.0  # in the gap
    far = choose_rejoin(two, 4.5, 1.5)
    assert two.lengths[far.knot] == 14.5
    assert far.room == pytest.approx(4.5)
    assert not far.skips_corner
    nearer = choose_rejoin(two, 12.0, 1.5)  # no such lead: the next shorter one
    assert two.lengths[nearer.knot] == 13.0
    assert choose_rejoin(stretch(np.arange(4.05, 21, 1.0), [3.0, 0.0]), 4.5, 1.5) is None


def test_a_corner_is_skipped_only_when_nothing_else_is_possible():
    short = stretch([5.05], [4.0, 0.0], corner=8.5)
    place = choose_rejoin(short, 4.5, 1.5)
    assert short.lengths[place.knot] <= 8.5
    assert not place.skips_corner
    blocked = stretch([5.05], [4.0, 0.0], corner=5.5)
    assert choose_rejoin(blocked, 4.5, 1.5).skips_corner


@pytest.mark.parametrize("halvings", [1, 3])
def test_a_refined_curve_is_the_same_curve(halvings):
    """Lane and Riesenfeld: more control points, the same position, velocity, acceleration."""
    rng = np.random.default_rng(5)
    coarse = Trajectory(2.0, 0.5, rng.normal(size=(9, 3)))
    fine = refined(coarse, halvings)
    assert fine.end == pytest.approx(coarse.end)
    times = np.linspace(coarse.start, coarse.end, 57)
    for a, b in zip(coarse.sample(times), fine.sample(times), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)


def test_control_points_and_the_state_at_a_knot_tell_the_same():
    rng = np.random.default_rng(6)
    control = rng.normal(size=(7, 3))
    again = controls_of(knot_state(control, 3, 0.25), 0.25)
    np.testing.assert_allclose(again, control[3:6], atol=1e-12)
    coarse = controls_of(knot_state(control, 3, 0.25), 0.5)
    np.testing.assert_allclose(
        knot_state(coarse, 0, 0.5).velocity_site, knot_state(control, 3, 0.25).velocity_site
    )
