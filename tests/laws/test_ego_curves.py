"""The parts of `ego`: gradients that agree with their costs, joins without a step, pairs, cells."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.avoidance.ego._kernels import fit
from orchard_cli.avoidance.ego.anchors._kernels import BLOCKED, MOST, add_pairs
from orchard_cli.avoidance.ego.cells._kernels import inflate, is_blocked
from orchard_cli.avoidance.ego.cost._kernels import total_cost
from orchard_cli.avoidance.ego.initial import Pace, quintic, through
from orchard_cli.avoidance.ego.search._kernels import find_way
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.model.trajectory import MotionState, Trajectory
from orchard_cli.motion.join import join_at

FRAME = np.array([0.0, -3.0, 2.0, 0.1])


def wavy(rng, n=12, interval=0.5, start=3.0):
    steps = np.array([0.45, 0.0, 0.0]) + rng.uniform(-0.2, 0.2, (n, 3))
    return Trajectory(start, interval, np.cumsum(steps, axis=0))


def pole(low=3.0, high=3.3):
    grid = np.zeros((70, 60, 30), dtype=bool)
    i = slice(round(low / 0.1), round(high / 0.1))
    grid[i, 28:32] = True
    return grid


def line(y=0.0, n=18):
    return np.column_stack([0.4 * np.arange(n), np.full(n, y), np.full(n, 3.5)])


@pytest.mark.parametrize("kind", range(4))
def test_each_term_of_the_cost_has_its_own_gradient(kind):
    rng = np.random.default_rng(kind)
    n = 11
    q = np.cumsum(rng.uniform(-0.3, 0.8, (n, 3)), axis=0)
    places, pushes = rng.uniform(-1, 4, (n, MOST, 3)), rng.normal(size=(n, MOST, 3))
    pushes /= np.linalg.norm(pushes, axis=2)[..., None]
    counts = rng.integers(0, 4, n)
    wanted, tangents = rng.normal(size=(n - 2, 3)), rng.normal(size=(n - 2, 3))
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    weights = np.eye(4)[kind]
    parts = np.empty(1)

    def cost(q, grad):
        return total_cost(
            q, 0.48, weights, np.array([0.8, 0.5, 0.5]), places, pushes, counts, wanted,
            tangents, grad, parts,
        )  # fmt: skip

    grad, spare = np.empty_like(q), np.empty_like(q)
    assert cost(q, grad) > 0
    assert not grad[:3].any()
    assert not grad[-3:].any()
    for i in range(3, n - 3):
        for c in range(3):
            step = np.zeros_like(q)
            step[i, c] = 1e-6
            slope = (cost(q + step, spare) - cost(q - step, spare)) / 2e-6
            assert grad[i, c] == pytest.approx(slope, rel=1e-4, abs=1e-5)


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 999),
    now=st.floats(3.0, 9.5),
    wait=st.floats(0.05, 0.45),
    own=st.sampled_from([0.25, 0.5]),
    interval=st.floats(0.3, 0.7),
)
def test_a_join_equals_what_is_flown_up_to_the_commit_time(seed, now, wait, own, interval):
    """PEERS: setpoints that jump. The original's joins miss by up to 4 cm; these are exact."""
    active = wavy(np.random.default_rng(seed), n=30 if own == 0.25 else 15, interval=own)
    rest = active.control_points_site[-1]
    active = Trajectory(
        active.start, own, np.vstack([active.control_points_site, rest, rest])
    )  # at rest in the end
    join = join_at(active, now, now + wait, interval)
    assert join.time >= now + wait - 1e-9
    new = Trajectory(join.start, join.interval, np.vstack([join.points_site, rest]))
    for t in np.linspace(max(now, active.start), now + wait, 9):
        a, b = active.at(t), new.at(t)
        np.testing.assert_allclose(a.position_site, b.position_site, atol=1e-9)
        np.testing.assert_allclose(a.velocity_site, b.velocity_site, atol=1e-8)
        np.testing.assert_allclose(a.acceleration_site, b.acceleration_site, atol=1e-5)


def test_a_fit_of_a_splines_own_knots_is_that_spline():
    q = np.cumsum(np.random.default_rng(1).uniform(-0.2, 0.6, (14, 3)), axis=0)
    knots = (q[:-2] + 4 * q[1:-1] + q[2:]) / 6
    found = q.copy()
    found[3:-3] = 0.0
    fit(found, knots)
    np.testing.assert_allclose(found, q, atol=1e-9)


def test_polynomials_meet_both_states_and_the_point_between():
    rng = np.random.default_rng(2)
    a, b = (MotionState(0.0, *rng.normal(size=(3, 3))) for _ in range(2))
    middle = rng.normal(size=3)
    h = 1e-4
    for curve in (quintic(a, b, 3.0), through(a, middle, b, 3.0)):
        begin, end = curve.at(np.array([0, h, 2 * h])), curve.at(np.array([3 - 2 * h, 3 - h, 3.0]))
        np.testing.assert_allclose(begin[0], a.position_site, atol=1e-9)
        np.testing.assert_allclose(end[2], b.position_site, atol=1e-9)
        np.testing.assert_allclose((begin[2] - begin[0]) / (2 * h), a.velocity_site, atol=2e-3)
        np.testing.assert_allclose((end[2] - end[0]) / (2 * h), b.velocity_site, atol=2e-3)
    np.testing.assert_allclose(curve.at(np.array([1.5]))[0], middle, atol=1e-9)


def test_a_trapezoid_takes_the_published_time():
    pace = Pace(1.0, 1.0, 0.4, 0.48)
    assert pace.duration(4.0) == pytest.approx(5.0)
    assert pace.duration(0.25) == pytest.approx(0.5)


def test_inflation_is_a_cube_of_whole_cells():
    raw = np.zeros((9, 9, 9), dtype=bool)
    raw[4, 4, 4] = raw[0, 8, 0] = True
    out = np.empty_like(raw)
    inflate(raw, 2, out)
    wanted = np.zeros_like(raw)
    wanted[2:7, 2:7, 2:7] = wanted[:3, 6:, :3] = True
    assert (out == wanted).all()


def test_outside_the_window_everything_is_an_obstacle():
    grid = np.zeros((4, 4, 4), dtype=bool)
    assert not is_blocked(grid, FRAME, 0.2, -2.8, 2.2)
    assert is_blocked(grid, FRAME, -0.1, -2.8, 2.2)
    assert is_blocked(grid, FRAME, 0.2, -2.8, 2.5)


def test_the_way_round_is_free_and_keeps_the_height_of_both_ends():
    way = np.empty((1024, 3))
    for y in (-0.06, 0.01, 0.04):
        start, goal = np.array([2.42, y, 3.5 - 1e-12]), np.array([4.02, y, 3.5 + 1e-12])
        grid = pole()
        n = find_way(grid, FRAME, start, goal, way)
        assert 17 <= n <= 22
        assert not any(is_blocked(grid, FRAME, *p) for p in way[:n])
        np.testing.assert_allclose(way[:n, 2], 3.5, atol=1e-9)
        assert np.abs(np.diff(way[:n], axis=0)).max() <= 0.1 + 1e-9


def pairs(q, grid):
    n = len(q)
    places, pushes = np.empty((n, MOST, 3)), np.empty((n, MOST, 3))
    counts = np.zeros(n, dtype=np.int64)
    gained = add_pairs(q, 12, False, grid, FRAME, places, pushes, counts)
    return gained, places, pushes, counts


def test_a_curve_that_touches_nothing_has_no_pairs():
    gained, *_, counts = pairs(line(y=0.3), pole())
    assert gained == 0
    assert not counts.any()


def test_pairs_push_out_of_the_obstacle_and_stand_on_its_surface():
    q, grid = line(y=0.08), pole(2.7, 3.4)
    gained, places, pushes, counts = pairs(q, grid)
    assert gained == counts.sum() > 0
    for i in np.flatnonzero(counts):
        place, push = places[i, 0], pushes[i, 0]
        assert np.linalg.norm(push) == pytest.approx(1.0)
        assert push[1] > 0.9  # the near side
        assert not is_blocked(grid, FRAME, *(place + 0.02 * push))
        assert is_blocked(grid, FRAME, *(place - 0.12 * push))


def test_a_wall_across_the_window_has_no_way_round():
    grid = pole()
    grid[30:33] = True
    assert pairs(line(), grid)[0] == BLOCKED


def test_a_window_shows_the_grids_own_obstacles():
    grid = OccupancyGrid()
    grid._log_odds[:] = np.random.default_rng(3).integers(-3000, 4000, grid._log_odds.shape)
    for lower in ([-4.0, -3.0, 0.1], [-1.0, 2.0, 2.5], [10.0, -3.0, -5.0]):
        window = grid.window(np.array(lower), np.add(lower, [4.0, 3.0, 2.4]))
        cells = np.indices(window.occupied.shape).reshape(3, -1).T
        places = window.origin_site + (cells + 0.5) * window.cell
        assert (grid.is_occupied(places) == window.occupied.ravel()).all()
    with pytest.raises(ValueError, match="positive size"):
        grid.window(np.zeros(3), np.zeros(3))
