"""What `orchard bench` measures on, pole fields and frames, and how it checks what comes out."""

from __future__ import annotations

import numpy as np
import pytest

from orchard_cli.commands.benchmarks import frames, pole_fields, replanning
from orchard_cli.commands.benchmarks.pole_fields import FIELDS, HALF, KnownGrid, cases
from orchard_cli.commands.benchmarks.samples import Samples, Spread
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.model.depth import DepthFrame, d455
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import Pose
from orchard_cli.motion.stopwatch import Stopwatch

LEVEL = np.array([1.0, 0.0, 0.0, 0.0])


def test_a_spread_of_a_hundred_durations_is_read_off_them():
    spread = Spread.of([float(k) for k in range(101)])
    assert spread == Spread(101, 50.0, 95.0, 99.0, 100.0)
    with pytest.raises(ValueError, match="no durations"):
        Spread.of([])


def test_a_stage_that_raises_leaves_no_duration():
    samples = Samples()
    with pytest.raises(RuntimeError), samples.timed("broken"):
        raise RuntimeError
    assert not samples.cpu_ms


@pytest.mark.parametrize("field", FIELDS, ids=lambda field: field.name)
def test_fields_keep_start_and_target_free_and_force_a_pole_on_the_line(field):
    for case in cases(field, 30, seed=3):
        state = case.situation.active.at(case.situation.now)
        assert np.allclose(state.position_site[:2], 0.0, atol=1e-9)
        target = case.situation.reference.at(case.target_time).position_site[:2]
        assert np.linalg.norm(target) == pytest.approx(7.0, abs=0.02)
        nose, free = target / np.linalg.norm(target), case.poles
        if field.forced:
            ahead = case.poles[0] @ nose
            assert 2.0 <= ahead <= 4.5
            assert abs(case.poles[0] @ [-nose[1], nose[0]]) <= 0.2
            free = case.poles[1:]
        if len(free):
            assert np.hypot(*free.T).min() >= 2.0
            assert np.hypot(*(free - target).T).min() >= 1.3
        if np.linalg.norm(state.velocity_site) > 0.01:
            assert state.velocity_site[:2] @ nose == pytest.approx(
                np.linalg.norm(state.velocity_site)
            )


def test_fields_have_the_density_asked_for():
    random, nose = np.random.default_rng(5), np.array([1.0, 0.0])
    counts = [len(pole_fields._poles(FIELDS[1], nose, random)) for _ in range(2000)]
    cut_out = np.pi * (2.0**2 + 1.35**2)
    assert np.mean(counts) == pytest.approx(0.05 * ((2 * HALF) ** 2 - cut_out), rel=0.02)


def test_the_same_seed_gives_the_same_fields_and_another_one_others():
    def places(seed):
        return np.concatenate([case.poles for case in cases(FIELDS[4], 5, seed)])

    assert np.array_equal(places(1), places(1))
    assert not np.array_equal(places(1)[:3], places(2)[:3])


def test_the_known_map_holds_every_pole_and_nothing_else():
    poles = np.array([[3.04, -1.96], [-7.3, 5.55]])
    grid = KnownGrid()
    grid.know(poles)
    x, y = np.meshgrid(np.arange(-9.95, 10, 0.1), np.arange(-9.95, 10, 0.1), indexing="ij")
    centres = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 3.5)])
    low, high = (centres + np.array([0.0, 0.0, shift]) for shift in (-2.5, 2.5))
    assert grid.is_observed(low).all()
    assert grid.is_observed(high).all()
    away = np.hypot(*(centres[:, None, :2] - poles).transpose(2, 0, 1)).min(axis=1)
    occupied = grid.is_occupied(centres)
    assert occupied[away <= 0.15].all()
    assert not occupied[away > 0.15 + 0.0708].any()
    assert grid.is_observed(centres).all()
    band = grid.band(np.zeros(3), 8.0, 3.2, 3.8)
    assert band.observed.all()
    assert band.occupied.sum() == occupied[np.abs(centres[:, :2]).max(axis=1) < 8].sum()


def test_the_check_of_a_path_needs_nothing_of_what_it_checks_and_agrees_with_it():
    random = np.random.default_rng(2)
    points = np.cumsum(random.uniform(0, 0.5, (40, 3)), axis=0)
    trajectory = Trajectory(12.0, 0.5, points)
    path = replanning._path(trajectory, 13.1, trajectory.end)
    times = np.append(np.arange(13.1, trajectory.end, 0.02), trajectory.end)
    ours = np.array([trajectory.at(t).position_site for t in times])
    assert np.allclose(path, ours, atol=1e-9)


def test_clearance_is_to_the_poles_surface():
    path = np.array([[0.0, 0.0, 3.0], [1.0, 0.0, 9.0], [2.0, 0.0, 3.0]])
    assert replanning.clearance(path, np.array([[1.0, 1.0], [5.0, 5.0]])) == pytest.approx(0.85)
    assert replanning.clearance(path, np.empty((0, 2))) == np.inf


def test_stages_of_a_system_are_told_in_cpu_time_and_afterwards_in_wall_time_again():
    import time

    with replanning.cpu_stopwatch():
        asleep = Stopwatch()
        with asleep.stage("sleep"):
            time.sleep(0.05)
    awake = Stopwatch()
    with awake.stage("sleep"):
        time.sleep(0.05)
    assert asleep.stages_ms["sleep"] < 25
    assert awake.stages_ms["sleep"] > 49


def test_a_thinned_frame_sees_the_same_places_up_to_four_and_a_half_metres():
    depth = np.zeros((480, 848), dtype=np.uint16)
    depth[::2, ::2] = 3000
    depth[100, 200] = 5000
    vehicle = frames.in_flight(Pose(1.0, np.array([0.0, 0.0, 3.0]), LEVEL), np.zeros(3))
    full = frames.Seen(DepthFrame(1.0, depth, d455()), vehicle)
    (stretch,) = frames.thinned([frames.Stretch((full,), None)])
    camera = stretch.seen[0].frame.camera
    assert stretch.seen[0].frame.depth_mm.shape == (camera.height, camera.width) == (240, 424)
    for u, v in ((0, 0), (212, 120), (423, 239)):
        assert (u - camera.cx) / camera.fx == pytest.approx((2 * u - d455().cx) / d455().fx)
        assert (v - camera.cy) / camera.fy == pytest.approx((2 * v - d455().cy) / d455().fy)
    wall = np.full((480, 848), 3000, dtype=np.uint16)
    (seen,) = frames.thinned(
        [frames.Stretch((frames.Seen(DepthFrame(1.0, wall, d455()), vehicle),), None)]
    )[0].seen
    report = OccupancyGrid().insert(seen.frame, vehicle.pose)
    assert report.returns == 240 * 424
    assert camera.range_max == 4.5


def test_routes_end_before_each_pole_in_their_way(lemon):
    mission, world = lemon
    ends = frames.approaches(mission.trajectory, world)
    assert len(ends) == 4
    for end in ends:
        here = mission.trajectory.at(end).position_site
        away = min(np.hypot(here[0] - p.x, here[1] - p.y) for p in world.poles)
        assert 1.0 < away < 2.5


@pytest.fixture(scope="module")
def lemon():
    from orchard_cli import mission as missions
    from orchard_cli.commands.demo import NAME
    from orchard_cli.commands.shipped import MISSIONS
    from orchard_cli.commands.wiring import load_world

    mission = missions.load(MISSIONS / f"{NAME}.mission.json")
    return mission, load_world(mission, MISSIONS / f"{NAME}.world.toml")[0]


def test_drawn_frames_repeat_bit_by_bit_and_stand_beside_their_pose(lemon):
    first, again = (frames.drawn(*lemon, 4, Samples()) for _ in range(2))
    assert len(first) == 4
    for a, b in zip(first, again, strict=True):
        assert np.array_equal(a.seen[0].frame.depth_mm, b.seen[0].frame.depth_mm)
        assert a.seen[0].frame.time == a.seen[0].vehicle.time


def test_low_frames_are_fuller(lemon):
    def share(stretches):
        depth = np.stack([seen.frame.depth_mm for s in stretches for seen in s.seen])
        return ((depth >= 600) & (depth <= 6000)).mean()

    as_flown, low = (frames.drawn(*lemon, 4, Samples(), low=low) for low in (False, True))
    assert share(low) > 2 * share(as_flown)


def test_speeds_of_cases_cover_standing_to_cruise():
    speeds = [
        np.linalg.norm(case.situation.vehicle.velocity_site) for case in cases(FIELDS[2], 60, 1)
    ]
    assert min(speeds) < 0.1
    assert 0.9 < max(speeds) <= 1.01
    assert pole_fields.RADIUS == 0.15
