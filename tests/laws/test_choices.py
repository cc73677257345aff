"""What the crew may choose: lines, order, turns, sorties, resume. Nothing missed or doubled."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli import mission as missions
from orchard_cli.errors import InputError
from orchard_cli.flight.spray import SPEED_TOLERANCE
from orchard_cli.mission import lines, resume, route, sorties
from orchard_cli.mission.inspection import inspect
from orchard_cli.model.mission import Leg, Limits, Tank
from orchard_cli.model.site import KnownObstacle
from orchard_cli.model.wishes import (
    Direction,
    FlightWishes,
    FlyOver,
    Follow,
    HeightAbove,
    Pattern,
    StartRow,
    StartSide,
    Turn,
)
from tests.laws.test_mission import PROVENANCE, orchard, plan, row

FIVE = orchard(*(row(6 * k, 0.3 * (k % 2)) for k in range(5)))


def wishes(**more):
    return FlightWishes(**{"height": 3.5, **more})


def sprayed_rows(mission):
    return [segment.row for segment, _ in mission.spray_lines]


def strips(passes, swath=3.0):
    return [
        shapely.LineString(p.points_site[:, :2]).buffer(swath / 2, cap_style="flat") for p in passes
    ]


def test_one_pass_a_row_is_the_paper_s_line():
    """Liu 2024, §5.2: above the first and the last tree."""
    for line, tree_row in zip(lines.spray_lines(FIVE, wishes()), FIVE.rows, strict=True):
        assert (line.points_site[:, :2] == tree_row.trunks_site[[0, -1]]).all()


def test_lines_between_rows_lie_midway():
    found = lines.spray_lines(FIVE, wishes(fly_over=FlyOver.BETWEEN))
    assert [line.row for line in found] == [0, 1, 2, 3]
    assert [line.points_site[0, 1] for line in found] == pytest.approx([3, 9, 15, 21])
    assert [line.points_site[:, 0].tolist() for line in found] == [pytest.approx([0.15, 12.15])] * 4


@pytest.mark.parametrize("over", FlyOver)
@pytest.mark.parametrize(("swath", "overlap"), [(3.0, 0.0), (3.0, 0.25), (2.5, 0.1), (7.0, 0.0)])
def test_with_an_overlap_neighbouring_strips_overlap_by_as_much_or_more(over, swath, overlap):
    found = lines.spray_lines(FIVE, wishes(fly_over=over, swath=swath, overlap=overlap))
    apart = np.diff([line.points_site[0, 1] for line in found])
    assert (apart <= swath * (1 - overlap) + 1e-9).all()
    assert (apart > swath * (1 - overlap) / 2 - 1e-9).all() or len(found) == len(FIVE.rows)
    treated = shapely.union_all([
        shapely.LineString(x.points_site[:, :2]).buffer(swath / 2, cap_style="flat") for x in found
    ])  # fmt: skip
    field = shapely.box(0.3, 3.0, 12.0, 21.0)
    assert field.difference(treated).area < 1e-6


def test_more_passes_a_row_share_the_distance_between_rows():
    found = lines.spray_lines(FIVE, wishes(passes=3))
    assert np.diff([x.points_site[0, 1] for x in found]) == pytest.approx(2.0)
    assert [x.row for x in found] == [k for k in range(5) for _ in range(3)]
    single = lines.spray_lines(orchard(row(0)), wishes(passes=2, swath=3.0))
    assert sorted(x.points_site[0, 1] for x in single) == pytest.approx([-1.5, 1.5])


@pytest.mark.parametrize(
    ("pattern", "start", "order"),
    [
        (Pattern.EVERY, StartRow.FIRST, [0, 1, 2, 3, 4]),
        (Pattern.OUT_AND_BACK, StartRow.FIRST, [0, 2, 4, 3, 1]),
        (Pattern.OUT_AND_BACK, StartRow.LAST, [4, 2, 0, 1, 3]),
        (Pattern.ALTERNATE, StartRow.FIRST, [0, 2, 4]),
        (Pattern.ALTERNATE, StartRow.LAST, [4, 2, 0]),
    ],
)
def test_rows_are_flown_in_the_wished_order(pattern, start, order):
    mission = plan(FIVE, pattern=pattern, start_row=start)
    assert sprayed_rows(mission) == order


@pytest.mark.parametrize("side", StartSide)
def test_one_way_flies_every_row_the_same_way_and_comes_back_with_the_pump_off(side):
    mission = plan(FIVE, direction=Direction.ONE_WAY, start_side=side)
    sign = 1 if side is StartSide.NEAR else -1
    for segment, points in mission.spray_lines:
        assert np.sign(points[-1, 0] - points[0, 0]) == sign
        speed = mission.trajectory.at((segment.start + segment.end) / 2).velocity_site
        assert np.sign(speed[0]) == sign
    between = [s.leg for s in mission.segments[2:-2:2]]
    assert between == [Leg.TRANSIT] * 4


@pytest.mark.parametrize("turn", Turn)
@pytest.mark.parametrize("headland", [0.0, 2.5])
def test_turns_lie_outside_the_last_trees_by_the_headland(turn, headland):
    """QGroundControl #7263: turnaround space at zero, or outside the trees."""
    mission = plan(FIVE, turn=turn, headland=headland, turn_radius=4.0)
    for segment in mission.segments:
        if segment.leg is not Leg.HEADLAND:
            continue
        times = np.linspace(segment.start, segment.end, 50)
        x = mission.trajectory.sample(times)[0][:, 0]
        out = x.max() if x.mean() > 6 else -x.min()
        reach = 12.3 if x.mean() > 6 else 0.0
        if turn is Turn.SQUARE:
            assert out <= reach + headland + 0.05
        assert out >= reach + headland - 0.6
    if headland == 0 and turn is Turn.SQUARE:
        assert len(mission.waypoints_site) == 10


def test_a_loop_swings_wider_than_a_half_circle_and_turns_no_tighter_than_its_radius():
    wide = plan(FIVE, turn=Turn.LOOP, turn_radius=4.5, headland=1.0)
    half = plan(FIVE, turn=Turn.ROUNDED, headland=1.0)
    assert np.ptp(wide.waypoints_site[:, 0]) > np.ptp(half.waypoints_site[:, 0]) + 3
    speeds = wide.trajectory.sample(np.arange(10, wide.trajectory.end - 10, 0.1))
    v, a = speeds[1], speeds[2]
    turning = np.abs(v[:, 0] * a[:, 1] - v[:, 1] * a[:, 0])
    curvature = turning / np.linalg.norm(v[:, :2], axis=1) ** 3
    assert np.percentile(curvature[curvature > 0.05], 50) == pytest.approx(1 / 4.5, rel=0.3)


@given(
    st.sampled_from(Turn), st.sampled_from(Pattern), st.sampled_from(Direction),
    st.sampled_from(FlyOver), st.sampled_from(StartSide), st.sampled_from([0.0, 1.0, 3.0]),
    st.sampled_from(Follow),
)  # fmt: skip
@settings(max_examples=12, deadline=None, derandomize=True)
def test_every_choice_gives_a_mission_that_passes_every_check(
    turn, pattern, direction, over, side, headland, follow
):
    what = orchard(*(row(5 * k, 0.2 * k, slope=0.04) for k in range(4)))
    mission = plan(what, turn=turn, pattern=pattern, direction=direction, fly_over=over,
                   start_side=side, headland=headland, follow=follow, height=3.5)  # fmt: skip
    assert [f.rule.name for f in inspect(mission) if not f.ok] == []


def test_following_the_terrain_keeps_the_height_over_every_tree():
    hill = row(0)
    bump = np.array([0.0, 1.0, 2.0, 1.0, 0.0])
    hill = dataclasses.replace(hill, ground=bump)
    with_it = plan(orchard(hill), follow=Follow.TERRAIN).waypoints_site
    over = np.interp(hill.trunks_site[:, 0], with_it[:, 0], with_it[:, 2]) - bump
    assert over[1:-1] == pytest.approx(3.5, abs=0.05)
    assert over.min() >= 3.5 - 1e-6
    assert over.max() < 4.6


def test_following_canopies_is_as_high_as_over_the_tallest_neighbour():
    what = orchard(dataclasses.replace(row(0), heights=np.array([2.0, 2.0, 2.6, 2.0, 2.0])))
    points = plan(what, follow=Follow.TERRAIN, height_above=HeightAbove.CANOPY, height=1.0)
    z = np.interp(what.rows[0].trunks_site[:, 0], *points.waypoints_site[:, [0, 2]].T)
    assert z == pytest.approx([3.6] * 5, abs=0.05)


def test_liquid_is_dose_times_swath_times_length_or_flow_times_time():
    by_dose = plan(FIVE, tank=Tank(50.0, dose=0.015), swath=3.0)
    assert by_dose.liquid == pytest.approx(0.015 * 3.0 * 60.0)
    by_flow = plan(FIVE, tank=Tank(50.0, flow=0.02))
    seconds = sum(s.end - s.start for s in by_flow.segments if s.leg is Leg.ROW)
    assert by_flow.liquid == pytest.approx(0.02 * seconds, abs=1e-5)
    assert [f.rule.name for f in inspect(by_flow) if not f.ok] == []
    less = dataclasses.replace(by_flow, liquid=0.5)
    assert {f.rule.name for f in inspect(less) if not f.ok} >= {"stated liquid"}
    small = dataclasses.replace(by_flow, tank=Tank(1.0, flow=0.02))
    assert {f.rule.name for f in inspect(small) if not f.ok} >= {"liquid"}
    assert [f.where for f in missions.check(small)] == ["tank"]


def all_sorties(what=FIVE, **more):
    return missions.plan_sorties(what, wishes(**more), PROVENANCE)


def test_one_flight_is_one_mission():
    (mission,) = all_sorties()
    assert mission.sortie is None
    assert mission.landing_site != pytest.approx(mission.takeoff_site)


@pytest.mark.parametrize(
    "more",
    [
        {"tank": Tank(1.2, dose=0.015)},
        {"limits": Limits(endurance=150.0)},
        {"tank": Tank(1.2, dose=0.015), "limits": Limits(endurance=150.0)},
    ],
)
def test_sorties_are_cut_at_row_ends_and_leave_no_row_out_nor_twice(more):
    """Splitting into sorties by battery and tank, at row ends."""
    flights = all_sorties(**more)
    assert len(flights) > 1
    assert [m.sortie.number for m in flights] == list(range(1, len(flights) + 1))
    assert {m.sortie.of for m in flights} == {len(flights)}
    assert [r for m in flights for r in sprayed_rows(m)] == [0, 1, 2, 3, 4]
    home = flights[0].takeoff_site
    for mission in flights:
        assert mission.takeoff_site == pytest.approx(home)
        assert mission.landing_site == pytest.approx(home)
        assert mission.energy_share <= 1 - mission.limits.reserve
        assert mission.tank is None or mission.liquid <= mission.tank.capacity
        assert [f.rule.name for f in inspect(mission) if not f.ok] == []


def test_a_row_too_long_for_a_tank_is_told():
    with pytest.raises(InputError) as caught:
        all_sorties(tank=Tank(0.3, dose=0.015))
    assert "row 1" in caught.value.faults[0].where


def test_other_faults_are_no_reason_for_sorties():
    with pytest.raises(InputError) as caught:
        all_sorties(height=2.0, limits=Limits(endurance=120.0))
    assert any("tree" in fault.where for fault in caught.value.faults)


def test_a_transit_passes_above_what_stands_on_its_way():
    tall = orchard(row(0), row(6), row(12, height=5.0), row(18), row(24))
    mast = KnownObstacle(np.array([-4.0, 15.0]), 0.2, 9.0, "mast")
    what = dataclasses.replace(tall, obstacles=(mast,))
    parts = [p for p in route.passes(what, wishes()) if p.row == 4]
    (mission,) = missions.plan_from_home(what, wishes(), PROVENANCE, parts)
    findings = [f for f in inspect(mission) if not f.ok]
    assert findings == []
    assert mission.trajectory.at(0.0).position_site[2] > 9.8
    row_height = mission.trajectory.at((mission.segments[1].start + mission.segments[1].end) / 2)
    assert row_height.position_site[2] == pytest.approx(3.5)


def test_a_way_home_that_would_turn_straight_back_steps_aside():
    back = [p for p in route.passes(FIVE, wishes(start_side=StartSide.FAR)) if p.row == 0]
    there = wishes(takeoff_site=[-6.0, 0.0], start_side=StartSide.FAR)
    (mission,) = missions.plan_from_home(FIVE, there, PROVENANCE, back)
    assert [f.rule.name for f in inspect(mission) if not f.ok] == []


@cache
def passes():
    return route.passes(FIVE, wishes())


@given(st.integers(0, 4), st.floats(0.0, 1.0))
@settings(max_examples=60, derandomize=True)
def test_resume_leaves_no_strip_missed_nor_doubled(index, share):
    """Resume after a battery change at the exact stop (QGroundControl #5368, #5737, #9302;
    ArduPilot #11351)."""
    stop = resume.Stop(index, share * passes()[index].length)
    before = [*passes()[:index]]
    if stop.along > 0:
        before.append(resume.part(passes()[index], 0.0, stop.along))
    after = resume.rest(passes(), stop)
    whole, done, left = (
        shapely.union_all(strips(x)) if x else shapely.Polygon() for x in (passes(), before, after)
    )
    untold = passes()[index].length - stop.along < resume.SHORTEST
    allowed = resume.SHORTEST * 3.0 if untold else 1e-5
    assert whole.difference(done.union(left)).area <= allowed
    assert done.intersection(left).area < 1e-6
    assert left.difference(whole).area < 1e-6


@pytest.mark.parametrize(("text", "index", "along"), [
    ("1:5", 0, 5.0), ("2:5", 1, 7.0), ("5:0", 4, 0.0), ("5.0,0.2", 0, 5.0), ("5.3,5.5", 1, 7.0),
])  # fmt: skip
def test_the_place_to_resume_is_metres_from_the_first_tree_or_a_point(text, index, along):
    stop = resume.place(text, passes())
    assert (stop.index, stop.along) == (index, pytest.approx(along))


@pytest.mark.parametrize(
    "text", ["", "1", "1:", "9:1", "1:99", "0:1", "x,y", "5,3", "1:-2", "nan,0", "1e9,1", "1:2:3"]
)
def test_a_place_that_is_none_is_one_fault(text):
    with pytest.raises(InputError) as caught:
        resume.place(text, passes())
    assert caught.value.faults[0].where == "--resume-at"


def test_the_resumed_mission_sprays_from_the_stop_at_spray_speed():
    left = resume.rest(passes(), resume.place("3:4", passes()))
    (mission,) = missions.plan_from_home(FIVE, wishes(), PROVENANCE, left)
    first, points = mission.spray_lines[0]
    assert points[0, :2] == pytest.approx([4.0, 12.0])
    state = mission.trajectory.at(first.start)
    assert state.position_site[:2] == pytest.approx([4.0, 12.0], abs=0.03)
    lacking = 1.0 - np.linalg.norm(state.velocity_site)
    assert lacking < 0.5 * SPEED_TOLERANCE  # the pump runs
    assert [f.rule.name for f in inspect(mission) if not f.ok] == []


def flown(*spans):
    """Lines along the passes, as a log holds them: (pass, begin, end) m."""
    return [
        resume.part(passes()[k], a, b).points_site[:, :2][[0, -1]]
        + np.array([[0.0, 0.1], [0.0, -0.1]])
        for k, a, b in spans
    ]


def test_what_was_sprayed_is_read_line_by_line_and_gaps_before_the_stop_are_told():
    lines = flown((0, 0, 12), (1, 1, 4), (1, 9, 12), (2, 0, 5))
    behind = resume.passed(passes(), lines)
    assert [p.row for p in behind] == [0, 1, 2]
    assert behind[-1].length == pytest.approx(5.0, abs=0.01)
    found = resume.missed(passes(), behind, lines)
    assert [(m.row, m.length) for m in found] == [
        (1, pytest.approx(1.0, abs=0.01)), (1, pytest.approx(5.0, abs=0.01)),
    ]  # fmt: skip
    left = resume.remaining(passes(), [p.points_site for p in behind])
    assert [(p.row, round(p.length, 1)) for p in left] == [(2, 7.0), (3, 12.0), (4, 12.0)]
    again = resume.remaining(passes(), lines)
    assert [(p.row, round(p.length, 1)) for p in again[:3]] == [(1, 1.0), (1, 5.0), (2, 7.0)]
    (mission,) = missions.plan_from_home(FIVE, wishes(), PROVENANCE, again)
    assert sprayed_rows(mission) == [1, 1, 2, 3, 4]
    assert [f.rule.name for f in inspect(mission) if not f.ok] == []


def test_sorties_flown_in_another_order_leave_what_neither_has_sprayed():
    """The first one stopped half way; the second one, over the last rows, was flown whole."""
    first, second = passes()[:3], passes()[3:]
    behind = resume.passed(first, flown((0, 0, 12), (1, 0, 6)))
    behind += resume.passed(second, flown((3, 0, 12), (4, 0, 12)))
    left = resume.remaining(passes(), [p.points_site for p in behind])
    assert [(p.row, round(p.length, 1)) for p in left] == [(1, 6.0), (2, 12.0)]


def test_spraying_against_the_direction_of_a_line_is_no_treatment_of_it():
    backwards = [line[::-1] for line in flown((0, 0, 12))]
    assert resume.sprayed_parts(passes(), backwards)[0] == []


def test_the_home_of_a_resumed_flight_is_that_of_the_whole_one():
    assert sorties.take_off(FIVE, wishes()) == pytest.approx(plan(FIVE).takeoff_site)


def test_a_low_flight_stays_low_on_the_way_where_that_is_clear():
    """2.86 m over canopies of 2 m keep the clearance of 0.85 m everywhere."""
    left = [p for p in passes() if p.row == 2]
    lower = [route.Pass(p.row, p.points_site - [0, 0, 0.64]) for p in left]
    (mission,) = missions.plan_from_home(FIVE, wishes(height=2.86), PROVENANCE, lower)
    assert np.ptp(mission.trajectory.control_points_site[:, 2]) < 1e-6
    assert [f.rule.name for f in inspect(mission) if not f.ok] == []
