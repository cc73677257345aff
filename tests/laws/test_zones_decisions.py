"""Zones, strategies and avoidance points of Wang 2020: pure decisions."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.avoidance.zones.decide import Act, Ahead, Zone, decide
from orchard_cli.avoidance.zones.points import Way, avoidance_points, clear_offset
from orchard_cli.avoidance.zones.settings import ZonesSettings
from orchard_cli.avoidance.zones.tracks import follow
from orchard_cli.model.obstacles import Category, Detection, Obstacle
from orchard_cli.motion.path import Path

S = ZonesSettings()
HEIGHT, BELOW = 3.0, 0.85


def thing(category, near=4.0, aside=0.0, width=0.4, bottom=0.0, top=8.0):
    detection = Detection(category, 0.9, 0.0, 0.0, 1.0, 1.0)
    place = np.array([0.0, 0.0, (bottom + top) / 2])
    obstacle = Obstacle(detection, near, width, place, bottom, top)
    return Ahead(obstacle, near + width / 2, aside, HEIGHT)


def judged(*seen, glimpsed=None):
    return decide(seen, glimpsed, BELOW, S)


@pytest.mark.parametrize(
    ("near", "zone", "act"),
    [
        (8.5, Zone.CLEAR, Act.FLY_ON),
        (7.0, Zone.WARNING, Act.SLOW_DOWN),
        (4.0, Zone.ACTION, Act.AVOID),
        (1.0, Zone.EMERGENCY, Act.HOVER),
    ],
)
def test_the_zone_follows_the_distance(near, zone, act):
    decision = judged(thing(Category.POLE, near))
    assert (decision.zone, decision.act) == (zone, act)
    assert decision.alarm == (act is Act.HOVER)


@pytest.mark.parametrize("category", [Category.PERSON, Category.DRONE])
@pytest.mark.parametrize("top", [1.8, 3.0])
def test_a_person_or_drone_stops_the_flight_at_any_height(category, top):
    decision = judged(thing(category, 4.0, aside=1.5, top=top))
    assert decision.act is Act.HOVER
    assert decision.alarm
    assert judged(thing(category, 4.0, aside=3.0, top=top)).act is Act.FLY_ON


@pytest.mark.parametrize(
    ("seen", "first"),
    [
        (thing(Category.POLE, aside=0.3), Way.RIGHT),
        (thing(Category.POLE, aside=-0.3), Way.LEFT),
        (thing(Category.TREE, aside=0.3, width=2.0), Way.RIGHT),
        (thing(Category.TREE, aside=0.3, width=2.0, top=2.8), Way.OVER),
        (thing(Category.BUILDING, width=3.0, top=2.5), Way.OVER),
        (thing(Category.POLE, top=2.8), Way.LEFT),
        (thing(Category.TREE, width=2.0, top=5.5), Way.LEFT),
    ],
)
def test_the_strategy_by_category_and_quadrant(seen, first):
    assert judged(seen).ways[0] is first


def test_nothing_leads_round_a_wire():
    decision = judged(thing(Category.WIRE, width=12.0, bottom=2.8, top=3.0))
    assert decision.act is Act.AVOID
    assert decision.ways == ()


@pytest.mark.parametrize(
    "seen",
    [
        thing(Category.TREE, top=HEIGHT - BELOW - 0.01, width=2.0),  # d_z > 0
        thing(Category.POLE, aside=1.3),  # d_x > 0
        thing(Category.WIRE, bottom=HEIGHT + 1.1, top=HEIGHT + 1.2, width=9.0),
        thing(Category.POLE, near=-3.0),  # behind
    ],
)
def test_what_does_not_reach_into_the_passing_area_is_ignored(seen):
    assert judged(seen).act is Act.FLY_ON


def test_what_is_glimpsed_slows_the_flight():
    decision = judged(glimpsed=Category.TREE)
    assert (decision.zone, decision.act) == (Zone.WARNING, Act.SLOW_DOWN)


def test_the_nearest_in_the_way_decides():
    pole, person = thing(Category.POLE, 3.0), thing(Category.PERSON, 4.0, top=1.8)
    assert judged(person, pole).act is Act.AVOID
    assert judged(pole, thing(Category.PERSON, 2.0, top=1.8)).act is Act.HOVER


near_right = st.floats(0.3, 3.0)
courses = st.floats(-math.pi, math.pi)


@settings(max_examples=50, deadline=None)
@given(courses, near_right, st.floats(2.0, 5.0), st.sampled_from(Way))
def test_the_points_are_beside_and_behind_the_obstacle(course, offset, reach, way):
    """Eqs. 3-8, whatever the course: P_2 is d ahead and d_x aside or d_z up, P_3 is 2 d ahead."""
    start = np.array([3.0, -2.0, 4.0])
    points = avoidance_points(start, course, way, offset, reach)
    ahead = np.array([math.sin(course), math.cos(course)])
    right = np.array([math.cos(course), -math.sin(course)])
    beside, behind = points.beside - start, points.behind - start
    side = {Way.LEFT: -offset, Way.RIGHT: offset, Way.OVER: 0.0}[way]
    np.testing.assert_allclose(
        [beside[:2] @ ahead, beside[:2] @ right, beside[2]],
        [reach, side, offset if way is Way.OVER else 0.0], atol=1e-9,
    )  # fmt: skip
    np.testing.assert_allclose(
        [behind[:2] @ ahead, behind[:2] @ right, behind[2]], [2 * reach, 0.0, 0.0], atol=1e-9
    )


@settings(max_examples=50, deadline=None)
@given(st.floats(-1.0, 1.0), st.floats(2.0, 5.0), st.floats(0.2, 0.9))
def test_the_legs_keep_clear_of_the_obstacle(aside, reach, share):
    keep = share * reach
    offset = clear_offset(aside, reach, keep)
    leg = np.array([offset, reach]) / math.hypot(offset, reach)  # (aside, ahead) from P_1
    distance = abs(aside * leg[1] - reach * leg[0])
    assert distance == pytest.approx(keep)
    assert clear_offset(aside, reach, reach) is None


def test_one_thing_is_one_track_and_keeps_the_category_of_most_looks():
    tracks = ()
    kinds = [Category.POLE, Category.TREE, Category.POLE, Category.POLE]
    for k, category in enumerate(kinds):
        seen = thing(category, width=0.4 if category is Category.POLE else 3.0).obstacle
        tracks = follow(tracks, (seen,), k / 15, 1.0)
    assert len(tracks) == 1
    assert tracks[0].looks == 4
    assert tracks[0].obstacle.category is Category.POLE
    assert tracks[0].obstacle.width == pytest.approx(0.4)


def test_what_is_not_seen_again_is_forgotten():
    """PEERS: in obstacle until restart because the map never decays."""
    tracks = follow((), (thing(Category.POLE).obstacle,), 0.0, 1.0)
    assert len(follow(tracks, (), 0.9, 1.0)) == 1
    assert follow(tracks, (), 1.1, 1.0) == ()


def test_where_a_path_passes_a_place():
    path = Path.through(np.array([[0.0, 0, 3], [10, 0, 3], [10, 10, 3]]))
    assert path.beside(np.array([4.0, 1.0])) == pytest.approx((4.0, 1.0))
    assert path.beside(np.array([4.0, -1.0])) == pytest.approx((4.0, -1.0))
    assert path.beside(np.array([11.0, 5.0])) == pytest.approx((15.0, -1.0))
    along, aside = path.beside(np.array([13.0, -4.0]))  # outside the corner: no nearer than it is
    assert (along, abs(aside)) == pytest.approx((10.0, 5.0))
    assert path.beside(np.array([-3.0, 0.5]))[0] == 0.0  # behind
    along, aside = path.beside(np.array([10.0, 14.0]))  # beyond the end: not met
    assert (along, abs(aside)) == pytest.approx((20.0, 4.0))


def test_a_vehicle_that_stands_meets_nothing_by_chance():
    still = Path.through(np.array([[1.0, 2, 3]] * 4) + 1e-9)
    assert still.beside(np.array([7.0, 2.1]))[0] <= 1e-6
