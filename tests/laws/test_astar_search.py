"""The improved A* of Huang 2021 against the plain one, and both against scipy's Dijkstra."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from orchard_cli.avoidance.astar.search import (
    DYNAMIC,
    IMPROVED,
    PLAIN,
    PRUNED,
    NoWay,
    Searcher,
    Way,
    _kernels,
)

VARIANTS = [PLAIN, DYNAMIC, PRUNED, IMPROVED]
SEARCHER = Searcher()  # shared on purpose: calls must not disturb each other


def field(seed: int, shape: tuple[int, ...], share: float = 0.3) -> np.ndarray:
    blocked = np.random.default_rng(seed).random(shape) < share
    blocked[(0,) * len(shape)] = blocked[(-1,) * len(shape)] = False
    return blocked


def corners(shape: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros(len(shape), int), np.array(shape) - 1


def shortest(blocked: np.ndarray) -> float:
    """Of scipy, over the same steps, each tried by looking at the box that it crosses."""
    rows, columns, weights = [], [], []
    index = np.arange(blocked.size).reshape(blocked.shape)
    for cell in np.argwhere(~blocked):
        for step in np.ndindex(*(3,) * blocked.ndim):
            there = cell + np.array(step) - 1
            if (there < 0).any() or (there >= blocked.shape).any() or (there == cell).all():
                continue
            low, high = np.minimum(cell, there), np.maximum(cell, there) + 1
            box = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
            if not blocked[box].any():
                rows.append(index[tuple(cell)])
                columns.append(index[tuple(there)])
                weights.append(np.linalg.norm(there - cell))
    graph = coo_matrix((weights, (rows, columns)), shape=(blocked.size,) * 2)
    return float(dijkstra(graph.tocsr(), indices=0)[-1])


def touched(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cells that a line between two centres enters, by dense sampling."""
    line = a + np.linspace(0, 1, 400)[:, None] * (b - a)
    return np.unique(np.floor(line + 0.5).astype(int), axis=0)


@given(seed=st.integers(0, 10**6), size=st.sampled_from([(12, 12), (9, 14), (6, 6, 5)]))
@settings(max_examples=25, deadline=None)
def test_plain_finds_the_shortest_way_and_none_where_there_is_none(seed, size):
    blocked = field(seed, size)
    found = SEARCHER.search(blocked, *corners(size), PLAIN)
    best = shortest(blocked)
    if isinstance(found, Way):
        assert found.length == pytest.approx(best)
    else:
        assert np.isinf(best)


@given(seed=st.integers(0, 10**6), size=st.sampled_from([(20, 20), (8, 8, 6)]))
@settings(max_examples=40, deadline=None)
def test_every_variant_stays_on_free_cells_from_start_to_goal(seed, size):
    blocked = field(seed, size)
    start, goal = corners(size)
    for variant in VARIANTS:
        found = SEARCHER.search(blocked, start, goal, variant)
        if isinstance(found, Way):
            assert (found.cells[0] == start).all()
            assert (found.cells[-1] == goal).all()
            for a, b in zip(found.cells[:-1], found.cells[1:], strict=True):
                assert not blocked[tuple(touched(a, b).T)].any()


@given(seed=st.integers(0, 10**6))
@settings(max_examples=40, deadline=None)
def test_key_turning_points_make_the_way_no_longer_and_no_more_crooked(seed):
    blocked = field(seed, (25, 25))
    bent, straight = (SEARCHER.search(blocked, *corners((25, 25)), v) for v in (PRUNED, IMPROVED))
    if isinstance(bent, Way):
        assert isinstance(straight, Way)
        assert straight.length <= bent.length + 1e-9
        assert straight.turns <= bent.turns
        assert straight.expanded == bent.expanded


@pytest.mark.parametrize("shape", [(15, 15), (9, 9, 7)])
def test_an_empty_grid_is_crossed_straight_and_hardly_searched(shape):
    start, goal = corners(shape)
    found = SEARCHER.search(np.zeros(shape, bool), start, goal)
    assert isinstance(found, Way)
    assert found.turns == 0
    assert found.expanded <= max(shape) + 2


def test_it_leaves_a_pocket_that_opens_away_from_the_goal():
    """Huang 2021, Fig. 5b: enclosed on the side of the target, all eight directions are tried."""
    blocked = np.zeros((11, 11), bool)
    blocked[3:8, 7] = blocked[3, 4:8] = blocked[7, 4:8] = True  # open to the left only
    start, goal = np.array([5, 5]), np.array([5, 10])
    found = SEARCHER.search(blocked, start, goal, IMPROVED)
    assert isinstance(found, Way)
    assert found.cells[:, 1].min() <= 4


@given(seed=st.integers(0, 10**6), size=st.sampled_from([(16, 16), (6, 7, 5)]))
@settings(max_examples=40, deadline=None)
def test_every_variant_finds_a_way_where_there_is_one(seed, size):
    blocked = field(seed, size, share=0.4)
    found = {isinstance(SEARCHER.search(blocked, *corners(size), v), Way) for v in VARIANTS}
    assert len(found) == 1


def test_a_goal_behind_walls_is_an_answer_and_no_error():
    blocked = np.zeros((9, 9), bool)
    blocked[4] = True
    assert isinstance(SEARCHER.search(blocked, *corners((9, 9))), NoWay)
    blocked[0, 0] = True
    assert isinstance(SEARCHER.search(blocked, *corners((9, 9))), NoWay)
    with pytest.raises(ValueError, match="outside"):
        SEARCHER.search(blocked, np.array([0, 0]), np.array([9, 9]))


def test_four_of_eight_and_thirteen_of_twenty_six_directions_are_kept():
    from orchard_cli.avoidance.astar.search import _LEVEL, _STEPS

    rng = np.random.default_rng(4)
    for steps, axes in ((_LEVEL, 2), (_STEPS, 3)):
        for goal in rng.integers(-9, 10, (200, 3)):
            goal[axes:] = 0
            if not goal.any():
                continue
            kept = [s for s in steps if _kernels._towards.py_func(s, *goal)]
            assert len(kept) == len(steps) // 2
            assert all(np.dot(s, goal) >= 0 for s in kept)


def test_kernels_compute_what_their_source_says():
    blocked = field(11, (12, 12))[:, :, None]
    for a, b in np.random.default_rng(0).integers(0, 12, (50, 2, 3)) * [1, 1, 0]:
        assert _kernels.sees(blocked, a, b) == _kernels.sees.py_func(blocked, a, b)


def test_table_5_cells_and_path_keep_the_papers_margins():
    """Huang 2021, Table 5: path at most +2.0 %, cells at least -74.9 %, turns at least -20.7 %."""
    rows = []
    for seed in range(60):
        blocked = field(seed, (40, 40))
        plain, ours = (SEARCHER.search(blocked, *corners((40, 40)), v) for v in (PLAIN, IMPROVED))
        if isinstance(plain, Way) and isinstance(ours, Way):
            rows.append([ours.length / plain.length, ours.expanded / plain.expanded,
                         ours.turns / plain.turns])  # fmt: skip
    length, cells, turns = np.median(rows, axis=0)
    assert length <= 1.02
    assert cells <= 1 - 0.749
    assert turns <= 1 - 0.207
