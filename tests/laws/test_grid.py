"""What the occupancy grid promises, whatever the vehicle sees."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from orchard_cli.mapping import GridSettings, OccupancyGrid, _kernels, distance_field
from orchard_cli.mapping.settings import RESOLUTION
from orchard_cli.model.depth import FORWARD, DepthCamera, DepthFrame, d455
from orchard_cli.model.vehicle import Pose

SMALL = DepthCamera(64, 48, 40.0, 40.0, 31.5, 23.5, 0.6, 6.0, FORWARD, np.array([0.1, 0.02, -0.05]))
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])


def wall(distance, time=0.0, camera=SMALL):
    """A frame that sees one flat wall across the whole view."""
    depth = np.full((camera.height, camera.width), round(1000 * distance), dtype=np.uint16)
    return DepthFrame(time, depth, camera)


def pose(time=0.0, position=(0.0, 0.0, 0.0), yaw=0.0, pitch=0.0, roll=0.0):
    x, y, z, w = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat()
    return Pose(time, np.array(position, dtype=float), np.array([w, x, y, z]))


def seen_at(at, u, v, depth, camera=SMALL):
    """Site position of what a pixel sees at a depth, worked out without the grid's own code."""
    w, x, y, z = at.site_from_body
    right, down = (u - camera.cx) / camera.fx * depth, (v - camera.cy) / camera.fy * depth
    body = np.array([depth, -right, -down]) + camera.position_body  # forward, left, up
    return np.asarray(at.position_site) + Rotation.from_quat([x, y, z, w]).apply(body)


def look(grid, frame, at, times=3):
    for _ in range(times):
        report = grid.insert(frame, at)
    return report


angles = st.floats(-0.6, 0.6)


@settings(max_examples=30, deadline=None)
@given(
    yaw=st.floats(-3.1, 3.1), pitch=angles, roll=angles,
    x=st.floats(-500, 500), y=st.floats(-500, 500), z=st.floats(-3, 8),
    distance=st.floats(1.5, 4.2), u=st.integers(6, 57), v=st.integers(6, 41),
)  # fmt: skip
def test_a_wall_is_occupied_where_it_stands_and_all_before_it_is_free(
    yaw, pitch, roll, x, y, z, distance, u, v
):
    at = pose(0.0, (x, y, z), yaw, pitch, roll)
    grid = OccupancyGrid(GridSettings(size=(128, 128, 128), min_returns=1))
    look(grid, wall(distance), at)
    on, before, behind = (
        np.array([seen_at(at, u, v, depth)]) for depth in (distance, 0.6 * distance, distance + 0.4)
    )
    near_wall = grid.occupied_cells(on[0], 0.3)  # rays are up to 0.11 m apart at 4.2 m
    assert len(near_wall)
    assert np.linalg.norm(near_wall - on, axis=1).min() < 0.25
    assert grid.is_observed(before)[0]
    assert not grid.is_occupied(before)[0]
    assert not grid.is_observed(behind)[0]


def test_a_return_marks_the_cell_that_holds_it():
    at = pose(yaw=0.7, pitch=0.1, roll=-0.2, position=(3.0, -2.0, 1.0))
    depth = np.zeros((48, 64), dtype=np.uint16)
    depth[30, 12] = 3210
    grid = OccupancyGrid(GridSettings(min_returns=1))
    look(grid, DepthFrame(0.0, depth, SMALL), at, times=2)
    cells = grid.occupied_cells(np.array([3.0, -2.0, 1.0]), 8.0)
    assert len(cells) == 1
    assert np.abs(cells[0] - seen_at(at, 12, 30, 3.21)).max() <= 0.05 + 1e-6


def test_pixels_without_a_return_say_nothing():
    grid = OccupancyGrid()
    report = look(grid, wall(0.0), pose())
    assert (report.returns, report.hit_cells, report.free_cells) == (0, 0, 0)


def test_returns_nearer_than_the_range_say_nothing():
    grid = OccupancyGrid()
    report = look(grid, wall(0.55), pose())
    assert (report.returns, report.hit_cells, report.free_cells) == (0, 0, 0)


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.4])
def test_returns_beyond_the_range_carve_up_to_it_and_hit_nothing(yaw):
    grid = OccupancyGrid()
    at = pose(yaw=yaw)
    report = look(grid, wall(9.0), at)
    assert report.hit_cells == 0
    assert grid.is_observed(seen_at(at, 32, 24, 5.8)[None])[0]
    assert not grid.is_observed(seen_at(at, 32, 24, 6.2)[None])[0]


def test_a_few_returns_among_holes_carve_nothing():
    depth = np.zeros((48, 64), dtype=np.uint16)
    depth[::4, ::2] = 5000  # two of the sixteen pixels of each block
    assert look(OccupancyGrid(), DepthFrame(0.0, depth, SMALL), pose()).free_cells == 0
    depth[::2] = 5000  # eight
    assert look(OccupancyGrid(), DepthFrame(0.0, depth, SMALL), pose()).free_cells > 1000


def test_a_cell_that_is_hit_is_not_missed_by_the_same_frame():
    """A thin thing at a cell's side, the far wall in sight through the cell's middle."""
    camera, at = d455(), pose()
    depth = np.full((480, 848), 5000, dtype=np.uint16)
    depth[232:236, 440:443] = 1500  # a cell is 30 px wide there
    grid = OccupancyGrid()
    grid.insert(DepthFrame(0.0, depth, camera), at)
    here = seen_at(at, 441, 234, 1.5, camera)[None]
    assert grid.probability(here)[0] == pytest.approx(grid.settings.p_hit, abs=1e-3)


def test_a_lone_pixel_in_the_air_is_no_obstacle():
    depth = np.full((48, 64), 5000, dtype=np.uint16)
    depth[24, 32] = 2500
    grid = OccupancyGrid()
    look(grid, DepthFrame(0.0, depth, SMALL), pose(), times=10)
    assert not len(grid.occupied_cells(np.array([2.6, 0.0, 0.0]), 0.3))


def test_a_ghost_of_one_frame_is_no_obstacle_and_a_thing_of_three_is():
    grid = OccupancyGrid()
    here = np.array([[1.65, 0.03, 0.02]])
    grid.insert(wall(1.55), pose())
    assert not grid.is_occupied(here)[0]
    look(grid, wall(5.0), pose(), times=20)  # seen free for long
    look(grid, wall(1.55), pose(), times=2)
    assert not grid.is_occupied(here)[0]
    grid.insert(wall(1.55), pose())
    assert grid.is_occupied(here)[0]


def test_an_old_obstacle_that_is_seen_through_goes_away():
    grid = OccupancyGrid()
    here = np.array([[1.65, 0.03, 0.02]])
    look(grid, wall(1.55), pose(), times=60)
    assert grid.is_occupied(here)[0]
    look(grid, wall(5.0), pose(), times=12)  # 0.8 s at 15 Hz
    assert not grid.is_occupied(here)[0]


def test_unseen_evidence_loses_half_in_a_half_life():
    grid = OccupancyGrid(GridSettings(half_life=10.0))
    look(grid, wall(1.55), pose(), times=60)
    places = np.array([[1.65, 0.03, 0.02], [0.8, 0.0, 0.0]])
    before = np.log(grid.probability(places) / (1 - grid.probability(places)))
    for now in np.arange(0.0, 21.0, 1 / 15):
        grid.decay(now)
    after = np.log(grid.probability(places) / (1 - grid.probability(places)))
    # 20 to 21 s have been paid for, in whole seconds per slab
    assert np.all(np.abs(after) <= np.abs(before) * 0.5**1.8)
    assert np.all(np.abs(after) >= np.abs(before) * 0.5**2.3 - 40 / RESOLUTION)
    assert not grid.is_occupied(places).any()


def test_evidence_fades_at_once_after_a_long_silence():
    grid = OccupancyGrid(GridSettings(half_life=10.0))
    look(grid, wall(1.55), pose(), times=60)
    grid.decay(100.0)
    assert not grid.is_occupied(np.array([[1.65, 0.03, 0.02]]))[0]


def test_the_grid_keeps_things_in_their_place_while_it_rolls():
    grid = OccupancyGrid(GridSettings(size=(64, 64, 64), roll_slack=0.3))
    look(grid, wall(1.55), pose())
    cells = {tuple(c) for c in np.round(grid.occupied_cells(np.zeros(3), 3.0), 6)}
    empty = wall(0.0)
    for step in np.linspace(0.0, 1.0, 20):
        grid.insert(empty, pose(position=(step, -step, 0.5 * step)))
    moved = {tuple(c) for c in np.round(grid.occupied_cells(np.zeros(3), 3.0), 6)}
    assert moved <= cells
    assert len(moved) > 0.5 * len(cells)


@settings(max_examples=15, deadline=None)
@given(st.lists(st.tuples(*[st.floats(-1.5, 1.5)] * 3, st.floats(-3, 3)), min_size=2, max_size=8))
def test_a_small_grid_knows_what_a_large_one_knows_of_the_space_it_never_left(moves):
    small = OccupancyGrid(GridSettings(size=(32, 32, 32), roll_slack=0.5))
    large = OccupancyGrid(GridSettings(size=(256, 256, 128), roll_slack=0.5))
    at = np.zeros(3)
    low, high = small.lower_site, small.upper_site
    for x, y, z, yaw in moves:
        at = at + np.array([x, y, z])
        for grid in (small, large):
            grid.insert(wall(1.234), pose(position=at, yaw=yaw))
        low, high = np.maximum(low, small.lower_site), np.minimum(high, small.upper_site)
    if (high - low < 0.1).any():
        return
    axes = [np.arange(a + 0.05, b, 0.1) for a, b in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    differing = small.probability(points) != large.probability(points)
    assert differing.sum() <= 0.005 * large.is_observed(points).sum()  # returns on a cell's border


def test_what_rolled_out_is_forgotten():
    grid = OccupancyGrid(GridSettings(size=(64, 64, 64)))
    look(grid, wall(1.55), pose())
    grid.insert(wall(0.0), pose(position=(1000.0, 0.0, 0.0)))
    grid.insert(wall(0.0), pose())
    assert not len(grid.occupied_cells(np.zeros(3), 5.0))
    assert not grid.is_observed(np.array([[1.0, 0.0, 0.0]]))[0]


def test_nothing_outside_the_grid_is_occupied_or_observed():
    grid = OccupancyGrid(GridSettings(size=(64, 64, 64)))
    look(grid, wall(1.55), pose())
    echo = np.array([[1.65 + 6.4 * n, 0.03, 0.02] for n in (-1, 1, 2)])  # same place in memory
    assert grid.is_occupied(np.array([[1.65, 0.03, 0.02]]))[0]
    assert not grid.is_occupied(echo).any()
    band = grid.band(np.zeros(2), 8.0, -0.2, 0.2)
    x = band.origin_site[0] + band.cell * (np.argwhere(band.observed)[:, 0] + 0.5)
    assert x.min() > 0.0
    assert x.max() < 2.2


def test_the_band_shows_the_columns_that_hold_obstacles_at_its_height():
    grid = OccupancyGrid()
    look(grid, wall(1.55), pose(yaw=0.4, pitch=0.1))
    band = grid.band(np.array([1.0, 0.5]), 4.0, -0.35, 0.25)
    assert band.occupied.any()
    x = band.origin_site[0] + band.cell * (np.arange(band.occupied.shape[0]) + 0.5)
    y = band.origin_site[1] + band.cell * (np.arange(band.occupied.shape[1]) + 0.5)
    for layer, ask in ((band.occupied, grid.is_occupied), (band.observed, grid.is_observed)):
        want = np.zeros_like(layer)
        for z in np.arange(-0.35, 0.26, 0.1):
            points = np.stack(np.broadcast_arrays(x[:, None], y, z), axis=-1).reshape(-1, 3)
            want |= ask(points).reshape(layer.shape)
        np.testing.assert_array_equal(layer, want)


def test_obstacle_cells_are_those_that_are_occupied():
    grid = OccupancyGrid(GridSettings(size=(64, 64, 64)))
    look(grid, wall(1.55), pose(yaw=0.4, pitch=0.1))
    axis = np.arange(-3.15, 3.2, 0.1)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    near = np.linalg.norm(points - [1.0, 0.0, 0.0], axis=1) <= 2.0
    want = points[near & grid.is_occupied(points)]
    got = grid.occupied_cells(np.array([1.0, 0.0, 0.0]), 2.0)
    assert len(want) > 100
    np.testing.assert_allclose(np.sort(got, axis=0), np.sort(want, axis=0), atol=1e-9)


def test_more_obstacle_cells_than_fit_at_first_are_all_told():
    grid = OccupancyGrid(GridSettings(min_returns=1))
    for yaw in np.linspace(-3, 3, 12):
        look(grid, wall(5.5), pose(yaw=yaw), times=2)
    points = grid.occupied_cells(np.zeros(3), 12.0)
    assert len(points) > 4096
    assert grid.is_occupied(points).all()
    assert len(np.unique(np.round(points, 3), axis=0)) == len(points)


def test_the_airframes_own_place_is_free():
    grid = OccupancyGrid()
    look(grid, wall(1.55), pose())
    centre = np.array([1.65, 0.03, 0.02])
    grid.clear_sphere(centre, 0.5)
    assert not len(grid.occupied_cells(centre, 0.45))
    assert grid.is_observed(centre[None])[0]
    assert len(grid.occupied_cells(centre, 1.0))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_pose_that_is_not_finite_is_refused(bad):
    grid = OccupancyGrid()
    with pytest.raises(ValueError, match="finite"):
        grid.insert(wall(2.0), Pose(0.0, np.array([bad, 0.0, 0.0]), LEVEL))


def test_a_frame_of_another_size_is_refused():
    with pytest.raises(ValueError, match="another camera"):
        OccupancyGrid().insert(DepthFrame(0.0, np.ones((4, 4), np.uint16), SMALL), pose())


def test_impossible_settings_are_refused_with_every_fault():
    with pytest.raises(ValueError, match=r"cell.*size.*p_.*half_life"):
        GridSettings(cell=0.0, size=(100, 64, 64), p_hit=0.4, half_life=0.0)


def test_the_memory_of_the_grid_does_not_grow():
    grid = OccupancyGrid(GridSettings(size=(64, 64, 64)))
    look(grid, wall(2.0), pose())
    arrays = grid._log_odds, grid._counts, grid._touched
    for x in range(50):
        grid.insert(wall(2.0), pose(position=(x, 0.0, 0.0)))
    assert all(
        a is b for a, b in zip(arrays, (grid._log_odds, grid._counts, grid._touched), strict=True)
    )
    assert not grid._counts.any()


def test_the_kernels_do_what_their_python_says(monkeypatch):
    """The compiled loops and the same functions run by the interpreter agree to the bit."""
    rng = np.random.default_rng(5)
    depth = rng.integers(0, 4000, (48, 64)).astype(np.uint16)
    frame, at = DepthFrame(0.0, depth, SMALL), pose(yaw=0.5, pitch=0.2, roll=0.1)
    size = GridSettings(size=(64, 64, 64))
    compiled, interpreted = OccupancyGrid(size), OccupancyGrid(size)
    told = look(compiled, frame, at, times=2)
    for name in ("nearest_blocks", "count_hits", "carve", "_inside", "vote_hits", "fade"):
        monkeypatch.setattr(_kernels, name, getattr(_kernels, name).py_func)
    assert look(interpreted, frame, at, times=2) == told
    np.testing.assert_array_equal(compiled._log_odds, interpreted._log_odds)


def test_no_kernel_is_compiled_twice_whatever_arrays_it_is_given():
    """A second compilation would stop a flight for a second."""
    frames = [
        wall(1.55),
        wall(1.55),
        DepthFrame(0.0, np.full((48, 128), 1500, np.uint16)[:, ::2], SMALL),
    ]
    frames[1].depth_mm.setflags(write=False)
    grid = OccupancyGrid(GridSettings(size=(64, 64, 64)))
    for n, frame in enumerate(frames):
        grid.insert(frame, pose(position=(n, 0.0, 0.0)))
    fixed = np.array([0.0, 0.0])
    fixed.setflags(write=False)
    for centre, half in ((np.zeros(3), 1.0), (fixed, 8.0), (np.array([3, 4]), 1.0)):
        field = distance_field(grid.band(centre, half, -0.2, 0.2), 0.5)
        for points in (np.zeros((3, 2)), np.zeros((6, 2), dtype=int)[::2], np.zeros((2, 3)).T):
            field.sample(points)
    for centre in (np.zeros(3), np.zeros(3, dtype=int), (0.0, 0.0, 0.0)):
        grid.occupied_cells(centre, 1.0)
        grid.clear_sphere(centre, 0.2)
    kernels = [kernel for kernel in vars(_kernels).values() if hasattr(kernel, "signatures")]
    assert len(kernels) > 8
    assert {k.py_func.__name__: len(k.signatures) for k in kernels if len(k.signatures) > 1} == {}
