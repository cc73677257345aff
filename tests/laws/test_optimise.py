"""The minimiser: downhill, ends fixed, out of obstacles, the same bits twice."""

import numpy as np
import pytest

from orchard_cli.motion.optimise import REFINE, WARM_UP, Weights, _kernels, optimise, span_cost

from .test_costs import TARGETS, TERMS, pole_field, wobbly


@pytest.mark.parametrize("name", TERMS)
@pytest.mark.parametrize("seed", range(10))
def test_never_ends_higher_than_it_began_and_keeps_its_ends(name, seed):
    span, guide = wobbly(seed, 16)
    field = pole_field()
    before = span.copy()
    after = optimise(span, guide, field, TERMS[name], TARGETS)
    cost = [span_cost(q, guide, field, TERMS[name], TARGETS)[0] for q in (span, after)]
    assert cost[1] <= cost[0]
    np.testing.assert_array_equal(span, before)
    np.testing.assert_array_equal(after[:3], span[:3])
    np.testing.assert_array_equal(after[-3:], span[-3:])


def test_the_guide_alone_is_reached():
    span, guide = wobbly(5, 16)
    after = optimise(span, guide, pole_field(), TERMS["guide"], TARGETS, tolerance=1e-12)
    np.testing.assert_allclose(after[3:-3], guide[3:-3], atol=1e-6)


def test_smooth_terms_reach_the_least_squares_answer():
    """Jerk and guide are quadratic: the answer is known in closed form."""
    span, guide = wobbly(7, 20)
    weights = Weights(0, 0.5, 0.02, 0, 0)
    after = optimise(span, guide, pole_field(), weights, TARGETS, 100, 1e-14)
    rows = np.diff(np.eye(20), 3, axis=0) * np.sqrt(0.5)
    pull = np.eye(20)[3:-3] * np.sqrt(0.02)
    free = np.vstack([rows, pull])[:, 3:-3]
    for c in range(2):
        known = np.delete(span[:, c], slice(3, 17))
        fixed = np.vstack([rows, pull])[:, [0, 1, 2, 17, 18, 19]] @ known
        aim = np.concatenate([np.zeros(len(rows)), guide[3:-3, c] * np.sqrt(0.02)])
        best = np.linalg.lstsq(free, aim - fixed, rcond=None)[0]
        np.testing.assert_allclose(after[3:-3, c], best, atol=1e-4)


@pytest.mark.parametrize("side", [0.05, -0.2, 0.4])
def test_two_stages_leave_the_pole_as_far_as_asked(side):
    n = 22
    line = np.column_stack([np.linspace(-5, 5, n), np.zeros(n)])
    guide = line.copy()
    guide[:, 1] = np.clip(1.3 - np.abs(line[:, 0]) * 0.3, 0, None) * np.sign(side)
    field = pole_field(0.0, -side / 10, half=6.0)
    warm = optimise(line, guide, field, WARM_UP, TARGETS)
    fine = optimise(warm, guide, field, REFINE, TARGETS)
    assert field.at(fine).min() > TARGETS.distance - 0.05


def test_repeats_to_the_bit():
    span, guide = wobbly(11, 16)
    field = pole_field()
    first, second = (optimise(span, guide, field, REFINE, TARGETS) for _ in range(2))
    assert first.tobytes() == second.tobytes()


def test_stiffness_factor_solves_its_matrix():
    weights = np.array([1.0, 0.5, 0.02, 0.5, 0.5])
    f = 9
    band = np.empty((f, 4))
    _kernels.stiffness(weights, band)
    lower = np.zeros((f, f))
    for i in range(f):
        for k in range(min(i, 3) + 1):
            lower[i, i - k] = band[i, k]
    second, third = np.diff(np.eye(f + 6), 2, axis=0), np.diff(np.eye(f + 6), 3, axis=0)
    full = 0.25 * second.T @ second + 2 * 0.5 * third.T @ third
    matrix = full[3:-3, 3:-3] + (2 * 0.02 + _kernels._GROUND) * np.eye(f)
    np.testing.assert_allclose(lower @ lower.T, matrix, atol=1e-12)
    x = np.random.default_rng(0).normal(size=(f, 2))
    solved = x.copy()
    _kernels.soften(band, solved)
    np.testing.assert_allclose(matrix @ solved, x, atol=1e-9)


def test_a_span_without_a_free_point_is_refused():
    with pytest.raises(ValueError, match="free point"):
        optimise(np.zeros((6, 2)), np.zeros((6, 2)), pole_field(), REFINE, TARGETS)
    with pytest.raises(ValueError, match="expected two nx2"):
        optimise(np.zeros((9, 2)), np.zeros((8, 2)), pole_field(), REFINE, TARGETS)
