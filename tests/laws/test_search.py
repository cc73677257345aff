"""A*: shortest, free, uncut corners, an honest no."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from orchard_cli.mapping import Band, distance_field
from orchard_cli.motion.search import NoRoute, Route, _kernels, find_route


def field_of(occupied, cell=0.1):
    band = Band(np.zeros(2), cell, occupied, np.ones_like(occupied), 3.0, 4.0)
    return distance_field(band, 1.8)


def poles(seed, n=60, count=4):
    rng = np.random.default_rng(seed)
    occupied = np.zeros((n, n), dtype=bool)
    for i, j in rng.integers(12, n - 12, (count, 2)):
        occupied[i : i + 2, j : j + 2] = True
    return occupied


def steps(free):
    """Every allowed step of the 8-connected grid, as a sparse graph of lengths."""
    n, m = free.shape
    rows, columns, lengths = [], [], []
    for i, j in np.argwhere(free):
        for di, dj in ((0, 1), (1, 0), (1, 1), (1, -1)):
            a, b = i + di, j + dj
            if 0 <= a < n and 0 <= b < m and free[a, b] and free[a, j] and free[i, b]:
                rows.append(i * m + j)
                columns.append(a * m + b)
                lengths.append(np.hypot(di, dj))
    return csr_matrix((lengths, (rows, columns)), shape=(n * m, n * m))


@pytest.mark.parametrize("seed", range(12))
def test_finds_the_shortest_path_of_the_grid(seed):
    rng = np.random.default_rng(seed)
    free = rng.random((24, 24)) > 0.3
    free[0, 0] = free[-1, -1] = True
    values = free.astype(np.float32)
    path = np.empty((free.size, 2), dtype=np.int32)
    count, _ = _kernels.find_path(
        values, 0.5, np.array([0, 0]), np.array([23, 23]), np.empty((0, 2)), 0.0, path
    )
    best = dijkstra(steps(free), directed=False, indices=0)[-1]
    if np.isinf(best):
        assert count == 0
        return
    walked = path[:count]
    hops = np.abs(np.diff(walked, axis=0))
    assert hops.max() == 1
    assert np.hypot(*hops.T).sum() == pytest.approx(best)
    for (i, j), (a, b) in pairwise(walked):
        assert free[a, b]
        assert free[a, j]
        assert free[i, b]


@pytest.mark.parametrize("seed", range(12))
def test_the_route_keeps_its_clearance_between_its_points_too(seed):
    field = field_of(poles(seed))
    route = find_route(field, np.array([0.35, 0.35]), np.array([5.6, 5.5]), 0.6)
    assert isinstance(route, Route)
    legs = [np.linspace(a, b, 40) for a, b in pairwise(route.points_site)]
    assert field.at(np.concatenate(legs)).min() > 0.6 - 0.12  # a coarse step may graze an edge


def test_an_enclosed_goal_is_a_no_with_its_cost():
    occupied = np.zeros((60, 60), dtype=bool)
    occupied[28:32, :] = True
    answer = find_route(field_of(occupied), np.array([0.5, 3.0]), np.array([5.5, 3.0]), 0.3)
    assert isinstance(answer, NoRoute)
    assert answer.cost > 100


def test_a_goal_inside_an_obstacle_or_outside_the_map_is_a_no():
    occupied = np.zeros((60, 60), dtype=bool)
    occupied[48:54, 28:34] = True
    field = field_of(occupied)
    assert isinstance(find_route(field, np.array([0.5, 3.0]), np.array([5.05, 3.05]), 0.3), NoRoute)
    assert isinstance(find_route(field, np.array([0.5, 3.0]), np.array([9.0, 3.0]), 0.3), NoRoute)


def test_a_start_that_is_too_near_may_leave():
    occupied = np.zeros((60, 60), dtype=bool)
    occupied[10, 30] = True
    answer = find_route(field_of(occupied), np.array([1.45, 3.05]), np.array([5.5, 3.0]), 0.9)
    assert isinstance(answer, Route)


@pytest.mark.parametrize("side", [-0.4, 0.4])
def test_the_way_stays_beside_the_path_being_flown(side):
    occupied = np.zeros((80, 80), dtype=bool)
    occupied[40, 40] = True
    x = np.linspace(1.0, 7.0, 13)
    flown = np.column_stack([x, 4.05 + np.sign(side) * 1.2 * np.exp(-((x - 4) ** 2)), 0 * x])
    route = find_route(field_of(occupied), flown[0], flown[-1], 0.8, near_site=flown, stray=0.05)
    assert np.sign(route.points_site[1:-1, 1].mean() - 4.05) == np.sign(side)
