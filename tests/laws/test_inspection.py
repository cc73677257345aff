"""`orchard check`: a second look finds what is wrong, by other means than the planner's."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from orchard_cli.mission.inspection import HeightBand, inspect
from orchard_cli.mission.inspection.flown import flown
from orchard_cli.mission.inspection.terrain import Terrain
from orchard_cli.model.mission import Leg
from orchard_cli.model.site import KnownObstacle, Orchard, TreeRow
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.world import Pole, World
from tests.laws.test_mission import ORIGIN, orchard, plan, row


@pytest.fixture(scope="module")
def mission():
    return plan(orchard(row(0), row(6, 0.5)))


def broken(mission, world=None, band=None, **changes):
    findings = inspect(dataclasses.replace(mission, **changes), world, band)
    return {f.rule.name: f for f in findings if not f.ok}


def test_a_planned_mission_breaks_nothing_and_every_rule_is_listed(mission):
    findings = inspect(mission)
    assert all(f.ok for f in findings)
    assert {f.rule.name for f in findings} >= {
        "clearance to the trees", "clearance to known obstacles", "inside the fence",
        "outside the keep-outs", "height above the ground", "speed", "acceleration",
        "yaw rate", "curvature at its speed", "duration", "energy", "places on earth",
    }  # fmt: skip


def test_clearance_is_the_distance_to_the_nearest_tree_s_top(mission):
    (found,) = [f for f in inspect(mission) if f.rule.name == "clearance to the trees"]
    assert found.figure == pytest.approx(1.5, abs=1e-3)


def with_orchard(mission, **changes):
    return {"orchard": dataclasses.replace(mission.orchard, **changes)}


def test_a_tree_that_is_too_tall_is_named_with_its_place(mission):
    first, second = mission.orchard.rows
    heights = np.array(second.heights)
    heights[2] = 3.0
    rows = (first, TreeRow(second.trunks_site, second.ground, heights))
    found = broken(mission, **with_orchard(mission, rows=rows))["clearance to the trees"]
    assert found.about == "row 2, tree 3"
    assert found.figure == pytest.approx(0.5, abs=0.01)
    assert np.hypot(*(found.place_site[:2] - second.trunks_site[2])) <= 1.6


def test_a_tree_beside_the_path_and_taller_than_it_is_seen():
    low = plan(orchard(row(0), row(6, 0.5)), height=3.5)
    rows = (*low.orchard.rows, row(3, height=8.0))
    found = broken(low, **with_orchard(low, rows=rows))
    assert found["clearance to the trees"].about.startswith("row 3")


@pytest.mark.parametrize("beside", [0.0, 0.9, -0.9])
def test_a_known_obstacle_nearer_than_the_clearance_breaks_it_on_either_side(mission, beside):
    pole = KnownObstacle(np.array([4.6, beside]), 0.15, 8.0, "mast")
    found = broken(mission, **with_orchard(mission, obstacles=(pole,)))
    assert found["clearance to known obstacles"].figure == pytest.approx(
        abs(beside) - 0.15, abs=0.03
    )
    far = KnownObstacle(np.array([4.6, 1.1 * np.sign(beside) or 3.0]), 0.15, 8.0)
    assert not broken(mission, **with_orchard(mission, obstacles=(far,)))


def test_the_world_s_poles_count_and_each_stretch_is_one_finding(mission):
    world = World("w", poles=(Pole(4.6, 0.0, 0.15, 8.0), Pole(8.0, 6.0, 0.15, 8.0)))
    rule = "clearance to the world's obstacles"
    found = [f for f in inspect(mission, world) if f.rule.name == rule]
    assert [f.ok for f in found] == [False, False]
    assert [f.place_site[1] for f in found] == [pytest.approx(0, abs=0.1), pytest.approx(6, abs=1)]


def test_fence_and_keep_outs_keep_the_airframe_s_radius(mission):
    fence = [[-4.3, -10], [40, -10], [40, 40], [-4.3, 40]]
    found = broken(mission, **with_orchard(mission, fence_site=fence))["inside the fence"]
    assert found.figure == pytest.approx(0.3, abs=0.01)
    keep_out = np.array([[5, 0.3], [7, 0.3], [7, 1], [5, 1]])
    found = broken(mission, **with_orchard(mission, keep_outs_site=(keep_out,)))
    assert found["outside the keep-outs"].figure == pytest.approx(0.3, abs=0.01)
    crossed = np.array([[20, 20], [22, 22], [22, 20], [20, 22]])
    assert "outside the keep-outs" in broken(
        mission, **with_orchard(mission, keep_outs_site=(crossed,))
    )


def test_height_is_judged_on_both_sides(mission):
    assert not broken(mission, band=HeightBand(3.4, 3.6))
    low = broken(mission, band=HeightBand(3.6, 9.0))["height above the ground"]
    assert (low.figure, low.rule.limit) == (pytest.approx(3.5), 3.6)
    assert "height above the ground" in broken(mission, band=HeightBand(1.0, 3.4))


@pytest.mark.parametrize(
    ("limit", "factor", "rules"),
    [
        ("speed", 0.9, {"speed"}),
        ("acceleration", 0.5, {"acceleration", "curvature at its speed"}),
        ("acceleration_along", 0.9, {"acceleration along the path"}),
        ("yaw_rate", 0.5, {"yaw rate", "curvature at its speed"}),
        ("endurance", 0.09, {"duration"}),
        ("reserve", 4.8, {"energy"}),
    ],
)
def test_each_limit_is_judged(mission, limit, factor, rules):
    limits = dataclasses.replace(mission.limits, **{limit: getattr(mission.limits, limit) * factor})
    found = set(broken(mission, limits=limits))
    assert found >= rules


def test_the_motion_is_read_as_the_flight_reads_it(mission):
    """Two codes for one spline: the planner's and SciPy's."""
    path = flown(mission.trajectory)
    positions, velocities, accelerations = mission.trajectory.sample(path.times)
    assert np.abs(path.positions - positions).max() < 1e-9
    assert np.abs(path.velocities - velocities).max() < 1e-9
    assert np.abs(path.accelerations - accelerations).max() < 1e-7


def test_a_circle_has_the_curvature_and_the_yaw_rate_of_a_circle():
    angles = np.arange(0, 6.5, 0.05)
    control = np.column_stack([5 * np.cos(angles), 5 * np.sin(angles), 0 * angles])
    path = flown(Trajectory(0.0, 0.25, control))
    assert path.curvatures == pytest.approx(0.2, rel=1e-2)
    assert path.yaw_rates == pytest.approx(0.2, rel=1e-2)
    assert path.accelerations_along == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_mirrored_places_on_earth_are_seen(mission, axis):
    """A wrong sign of an axis, or of the heading, sends a fleet into the neighbour's field."""
    from orchard_cli.geometry.geodesy import wgs84_from_site

    flip = np.ones(3)
    flip[axis] = -1
    mirrored = wgs84_from_site(mission.orchard.origin, mission.waypoints_site * flip)
    found = broken(mission, waypoints_wgs84=mirrored)
    assert found.keys() & {"places on earth", "heights on earth"}


def test_a_pump_that_runs_off_its_row_is_seen(mission):
    on_the_headland = tuple(
        dataclasses.replace(s, leg=Leg.ROW, row=0) if s.leg is Leg.HEADLAND else s
        for s in mission.segments
    )
    assert "spray line along its row" in broken(mission, segments=on_the_headland)
    swapped = tuple(
        dataclasses.replace(s, row=1 - s.row) if s.row is not None else s for s in mission.segments
    )
    found = broken(mission, segments=swapped)["spray line at its row"]
    assert found.figure == pytest.approx(6.0)
    late = tuple(dataclasses.replace(s, until=max(s.until - 1, 0)) for s in mission.segments)
    assert "pump on, beside the row" in broken(mission, segments=late)


def test_a_trajectory_longer_than_the_battery_is_not_looked_at_closer(mission):
    long = dataclasses.replace(mission.trajectory, interval=10.0)
    found = inspect(dataclasses.replace(mission, trajectory=long))
    assert [f.rule.name for f in found] == ["duration"]


def test_ground_is_linear_between_trees_and_nearest_outside():
    rows = (row(0, slope=0.1), row(6, slope=0.1))
    terrain = Terrain(Orchard("slope", ORIGIN, rows))
    places = np.array([[6.0, 0.0], [6.0, 3.0], [100.0, 0.0]])
    assert terrain.ground(places) == pytest.approx([0.6, 0.6, 1.2])
    single = Terrain(Orchard("slope", ORIGIN, rows[:1]))
    assert single.ground(np.array([[12.0, 1.0]])) == pytest.approx([1.2])
