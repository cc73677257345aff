"""Missions: the Π goes where the crew wished, keeps its distance, and what is unfit is refused."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli import mission as missions
from orchard_cli.errors import InputError
from orchard_cli.mission import energy, lines, route
from orchard_cli.mission.checks import flown
from orchard_cli.model.mission import Leg, Limits, Provenance, Segment
from orchard_cli.model.site import HeightReference, KnownObstacle, Orchard, SiteOrigin, TreeRow
from orchard_cli.model.wishes import FlightWishes, HeightAbove, StartRow, StartSide
from orchard_cli.motion.fit import distances
from orchard_cli.motion.timing import CRUISE, TOLERANCE, PathLimits, over_limits

ORIGIN = SiteOrigin(23.45, 113.13, 20.0, HeightReference.AMSL, np.radians(75.0))
PROVENANCE = Provenance("north.survey.toml", "0" * 64, "0.1", "2026-01-01T00:00:00+00:00")


def row(y, start=0.0, gaps=(3.0, 3.2, 2.8, 3.0), height=2.0, slope=0.0):
    x = start + np.concatenate([[0.0], np.cumsum(gaps)])
    trunks = np.column_stack([x, np.full(len(x), float(y))])
    return TreeRow(trunks, slope * x, np.full(len(x), float(height)))


def orchard(*rows, **more):
    return Orchard("test", ORIGIN, rows or (row(0), row(6, 0.5), row(12, -0.5)), **more)


def plan(what=None, **wishes):
    return missions.plan(what or orchard(), FlightWishes(**{"height": 3.5, **wishes}), PROVENANCE)


def faults_of(what=None, **wishes):
    with pytest.raises(InputError) as caught:
        plan(what, **wishes)
    return caught.value.faults


ends = {0: ([0, 0], [12, 0]), 1: ([0.5, 6], [12.5, 6]), 2: ([-0.5, 12], [11.5, 12])}


@pytest.mark.parametrize("start_row", StartRow)
@pytest.mark.parametrize("start_side", StartSide)
def test_waypoints_are_above_the_first_and_last_tree_of_each_row_in_turn(start_row, start_side):
    mission = plan(start_row=start_row, start_side=start_side)
    order = [0, 1, 2] if start_row is StartRow.FIRST else [2, 1, 0]
    wanted = []
    for k, index in enumerate(order):
        near, far = ends[index]
        wanted += [near, far] if (start_side is StartSide.NEAR) == (k % 2 == 0) else [far, near]
    assert mission.waypoints_site[:, :2] == pytest.approx(np.array(wanted, dtype=float))
    assert (mission.waypoints_site[:, 2] == 3.5).all()
    assert [s.row for s in mission.segments if s.leg is Leg.ROW] == order


def test_route_length_is_that_of_the_legs():
    mission = plan()
    assert mission.route_length == pytest.approx(3 * 12 + np.hypot(6, 0.5) + np.hypot(6, 1.0))


@st.composite
def orchards(draw):
    slope = draw(st.sampled_from([0.0, 0.05, -0.08]))
    rows, y = [], 0.0
    for _ in range(draw(st.integers(1, 4))):
        gaps = draw(st.lists(st.floats(2.5, 4.0), min_size=3, max_size=8))
        rows.append(row(y, draw(st.floats(-3, 3)), gaps, draw(st.floats(1.8, 2.4)), slope))
        y += draw(st.floats(3.0, 7.0))
    return orchard(*rows)


@given(orchards(), st.sampled_from(StartRow), st.sampled_from(StartSide), st.floats(0.25, 1.0))
@settings(max_examples=15, deadline=None, derandomize=True)
def test_a_planned_mission_keeps_every_promise(what, start_row, start_side, cut):
    m = plan(what, start_row=start_row, start_side=start_side, corner_cut=cut,
             height_above=HeightAbove.CANOPY, height=1.5)  # fmt: skip
    assert missions.check(m) == ()
    assert missions.measured_corner_cut(m) <= cut + 1e-5
    assert max(over_limits(m.trajectory, PathLimits.planned(m.limits)).values()) <= (1 + TOLERANCE)
    path = flown(m)
    for tree_row in what.rows:
        for trunk, top in zip(tree_row.trunks_site, tree_row.canopy_tops_site, strict=True):
            beside = np.hypot(*(path[:, :2] - trunk).T) < 0.5
            assert path[beside, 2].min(initial=np.inf) - top > 1.5 - 0.1  # corners cut slopes too
    assert distances(m.waypoints_site, path).max() <= cut + 0.02
    starts, stops = [s.start for s in m.segments], [s.end for s in m.segments]
    assert starts[0] == 0
    assert stops[-1] == m.trajectory.end
    assert starts[1:] == stops[:-1]


def test_segments_begin_and_end_where_the_waypoints_are_passed():
    mission = plan()
    inner = [s for s in mission.segments if s.leg is not Leg.TRANSIT]
    times = [s.start for s in inner] + [inner[-1].end]
    for time, waypoint in zip(times, mission.waypoints_site, strict=True):
        around = mission.trajectory.sample(np.linspace(time - 3, time + 3, 601))[0]
        nearest = np.linspace(-3, 3, 601)[np.linalg.norm(around - waypoint, axis=1).argmin()]
        assert abs(nearest) < 0.1
    assert mission.duration == times[-1] - times[0]


def test_cruising_speed_is_reached_before_the_first_tree_and_kept_past_the_last():
    mission = plan()
    for time in (mission.segments[0].end, mission.segments[-1].start):
        speed = np.linalg.norm(mission.trajectory.at(time).velocity_site)
        assert speed == pytest.approx(CRUISE * mission.limits.speed, rel=0.01)
    assert mission.takeoff_site == pytest.approx([-4, 0])
    assert mission.landing_site == pytest.approx([15.5, 12])


def test_the_run_up_grows_with_the_speed():
    slow, fast = Limits(speed=1.0), Limits(speed=3.0)
    assert route.run_up(slow) == 4.0
    assert route.run_up(fast) > 9 / (2 * 0.27)


def test_it_can_land_where_it_took_off():
    mission = plan(takeoff_site=[-4, 0], landing_site=[-4, 0])
    assert mission.landing_site == pytest.approx(mission.takeoff_site)


def test_it_takes_off_and_lands_where_the_crew_wished():
    mission = plan(takeoff_site=[-6, -5], landing_site=[3, 18])
    assert mission.takeoff_site == pytest.approx([-6, -5])
    assert mission.landing_site == pytest.approx([3, 18])
    states = mission.trajectory.at(0.0), mission.trajectory.at(mission.trajectory.end)
    assert [s.position_site[:2] for s in states] == [
        pytest.approx([-6, -5]), pytest.approx([3, 18]),
    ]  # fmt: skip


@given(st.lists(st.floats(-2, 4), min_size=2, max_size=12), st.randoms(use_true_random=False))
@settings(max_examples=100, derandomize=True)
def test_the_row_line_lies_over_every_tree_and_touches_one(tops, random):
    along = np.cumsum([random.uniform(1, 5) for _ in tops])
    z = lines.lowest_line_over(along, np.array(tops))
    line = np.interp(along, along[[0, -1]], z)
    assert (line >= np.array(tops) - 1e-9).all()
    assert (line - tops).min() < 1e-9


def test_height_above_canopy_follows_a_slope():
    what = orchard(row(0, slope=0.1), row(6, slope=0.1))
    z = plan(what, height=1.5, height_above=HeightAbove.CANOPY).waypoints_site[:, 2]
    assert z == pytest.approx([3.5, 4.7, 4.7, 3.5])


def test_one_row_is_a_mission_too():
    mission = plan(orchard(row(0)))
    assert [s.leg for s in mission.segments] == [Leg.TRANSIT, Leg.ROW, Leg.TRANSIT]
    assert missions.measured_corner_cut(mission) == 0


def test_height_under_the_canopy_is_refused_for_every_row():
    found = faults_of(orchard(row(0, height=3.0), row(6), row(12, height=4.0)), height=3.5)
    assert [(f.where, "below" in f.what) for f in found] == [
        ("row 1, tree 1", False), ("row 3, tree 1", True),
    ]  # fmt: skip
    assert "0.35 m higher" in found[0].mend


def test_clearance_over_the_canopy_is_kept_to_the_centimetre():
    assert plan(height=2.86)
    assert faults_of(height=2.84)


def test_a_route_longer_than_the_battery_is_refused_with_its_other_faults():
    rows = [row(6 * k, gaps=[3.0] * 20, height=3.2 if k == 4 else 2.0) for k in range(10)]
    found = {f.where: f.what for f in faults_of(orchard(*rows))}
    assert set(found) == {"battery", "row 5, tree 1"}
    assert "600 s battery" in found["battery"]


def test_a_route_that_only_the_way_to_it_makes_too_long_is_refused():
    limits = Limits(endurance=100.0)
    assert [f.where for f in faults_of(limits=limits)] == ["battery"]


def test_energy_counts_climb_flight_and_descent():
    limits = Limits(endurance=600.0, climb_speed=0.5)
    assert energy.share(300.0, 3.0, 4.0, limits) == pytest.approx((10 + 6 + 300 + 8) / 600)


def test_leaving_the_fence_or_entering_a_keep_out_is_refused():
    fence = [[-3, -10], [40, -10], [40, 40], [-3, 40]]
    keep_out = [[5, 5], [7, 5], [7, 7], [5, 7]]
    found = faults_of(orchard(fence_site=fence, keep_outs_site=(keep_out,)))
    assert [f.where for f in found] == ["fence", "keep_out 1"]
    wide = [[-9, -10], [40, -10], [40, 40], [-9, 40]]
    assert plan(orchard(fence_site=wide))


def test_a_turn_that_doubles_back_is_flown_within_the_corner_cut():
    """Row ends 12 m apart at 3 m between rows: 166 degrees."""
    mission = plan(orchard(row(0, gaps=[3.0] * 6), row(3, gaps=[3.0] * 2), row(6)))
    assert missions.measured_corner_cut(mission) <= 0.5 + 1e-5


def test_a_turn_that_cannot_be_rounded_is_refused():
    """Row ends 57 m apart at 0.6 m between rows: 179.4 degrees."""
    what = orchard(row(0, gaps=[3.0] * 20), row(0.6, gaps=[3.0]))
    assert "straight back" in faults_of(what)[0].what


@pytest.mark.parametrize(
    ("wish", "where"),
    [
        ({"takeoff_site": [6, 0]}, "flight.takeoff_m"),
        ({"landing_site": [3, 12]}, "flight.landing_m"),
    ],
)
def test_a_take_off_inside_the_row_line_is_refused(wish, where):
    assert where in [f.where for f in faults_of(**wish)]


def test_taking_off_or_landing_beside_a_tree_or_a_pole_is_refused():
    assert [f.where for f in faults_of(takeoff_site=[-1.0, 1.2])] == ["takeoff"]
    pole = KnownObstacle(np.array([15.5, 12.5]), 0.15, 8.0)
    with_pole = orchard(row(0), row(6, 0.5), row(12, -0.5), obstacles=(pole,))
    assert [f.where for f in faults_of(with_pole)] == ["landing"]


def test_a_known_obstacle_on_the_route_is_a_note_and_no_fault():
    on = KnownObstacle(np.array([4.6, 6.0]), 0.15, 8.0, "mast")
    off = KnownObstacle(np.array([4.6, 3.0]), 0.15, 8.0, "tower")
    low = KnownObstacle(np.array([7.0, 6.0]), 0.15, 2.0, "stump")
    mission = plan(orchard(row(0), row(6, 0.5), obstacles=(on, off, low)))
    (note,) = missions.notes(mission)
    assert "mast at (4.6, 6)" in note


def broken(mission, **changes):
    return [f.where for f in missions.check(dataclasses.replace(mission, **changes))]


def test_a_mission_whose_parts_disagree_is_faulted():
    m = plan()
    assert broken(m) == []
    assert broken(m, route_length=m.route_length + 1) == ["route_length_m"]
    assert broken(m, takeoff_site=m.takeoff_site + np.array([0, 1])) == ["trajectory start"]
    assert broken(m, landing_site=m.landing_site + np.array([0, 1])) == ["trajectory end"]
    assert broken(m, waypoints_wgs84=m.waypoints_wgs84 + 1e-6) == ["waypoints wgs84"]
    assert broken(m, energy_share=0.01) == ["energy_share"]
    assert broken(m, energy_share=0.9) == ["battery"]
    assert "waypoints" in broken(m, waypoints_site=m.waypoints_site + np.array([0, 2, 0]))
    fast = dataclasses.replace(m.limits, speed=0.9)
    assert broken(m, limits=fast) == ["trajectory"]


def test_a_trajectory_that_does_not_start_or_end_at_rest_is_faulted():
    m = plan()
    control = np.array(m.trajectory.control_points_site)
    moving = dataclasses.replace(m.trajectory, control_points_site=control[4:])
    assert "trajectory rest" in broken(m, trajectory=moving)


@pytest.mark.parametrize(
    "change",
    [
        lambda s: s[1:],
        lambda s: s[:-1],
        lambda s: (s[0], s[0], *s[1:]),
        lambda s: (*s[:2], *s[3:]),
        lambda s: (),
        lambda s: (s[0], dataclasses.replace(s[1], row=3), *s[2:]),
        lambda s: (s[0], dataclasses.replace(s[1], row=None), *s[2:]),
        lambda s: (Segment(Leg.TRANSIT, 0.0, s[0].end, 0), *s[1:]),
    ],
)
def test_segments_with_gaps_overlaps_or_wrong_rows_are_faulted(change):
    m = plan()
    assert any(where.startswith("segments") for where in broken(m, segments=change(m.segments)))


def test_rows_that_bend_are_said_to_be_flown_straight():
    x = np.arange(5) * 6.0
    bent = np.column_stack([x, 2.0 * np.sin(np.pi * x / 24.0)])
    what = orchard(TreeRow(bent, np.zeros(5), np.full(5, 2.0)), row(9, gaps=(6.0,) * 4))
    (note,) = missions.notes(plan(what))
    assert note.startswith("1 of 2 rows bend by more than 1 m, row 1 by 2.0 m: they are flown STRA")
    assert missions.notes(plan()) == ()


def test_with_stops_a_mission_rests_in_every_waypoint_and_keeps_its_limits():
    mission = plan()
    stopping = missions.with_stops(mission)
    flown = stopping.trajectory
    for segment in stopping.segments[:-1]:
        state = flown.at(segment.end)
        np.testing.assert_allclose(
            state.position_site, mission.waypoints_site[segment.until], atol=1e-6
        )
        assert np.abs(state.velocity_site).max() < 1e-6
    assert [s.leg for s in stopping.segments] == [s.leg for s in mission.segments]
    assert stopping.segments[-1].end == pytest.approx(flown.end)
    assert max(over_limits(flown, PathLimits.planned(mission.limits)).values()) <= 1 + TOLERANCE
    places = flown.sample(np.arange(0.0, flown.end, 0.1))[0]
    ends = [flown.at(time).position_site for time in (0.0, flown.end)]
    legs = np.vstack([ends[0], mission.waypoints_site, ends[1]])
    assert distances(places, legs).max() < 1e-3
    assert stopping.duration > mission.duration + 3 * (len(mission.waypoints_site) - 2)
    assert stopping.energy_share > mission.energy_share
    assert missions.dumps(missions.loads(missions.dumps(stopping).encode(), "x"))
