"""The terms of the optimisation: gradients, values, seams."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.mapping import Band, distance_field
from orchard_cli.motion._kernels import look_up
from orchard_cli.motion.checks import frame_of
from orchard_cli.motion.optimise import Targets, Weights, _kernels, span_cost

TARGETS = Targets(interval=0.5, speed=0.9, acceleration=0.3, distance=1.1)
TERMS = {
    "smooth": Weights(1, 0, 0, 0, 0),
    "jerk": Weights(0, 1, 0, 0, 0),
    "guide": Weights(0, 0, 1, 0, 0),
    "collision": Weights(0, 0, 0, 1, 0),
    "feasible": Weights(0, 0, 0, 0, 1),
    "all": Weights(1, 0.5, 0.02, 0.5, 0.5),
}


def pole_field(x=0.0, y=0.0, half=4.0):
    n = round(2 * half / 0.1)
    occupied = np.zeros((n, n), dtype=bool)
    i, j = round((x + half) / 0.1), round((y + half) / 0.1)
    occupied[i - 1 : i + 2, j - 1 : j + 2] = True
    return distance_field(
        Band(np.array([-half, -half]), 0.1, occupied, np.ones_like(occupied), 3.0, 4.0), 1.8
    )


def wobbly(seed, n=12):
    rng = np.random.default_rng(seed)
    line = np.column_stack([np.linspace(-2.7, 2.8, n), np.full(n, 0.13)])
    return line + rng.normal(0, 0.15, (n, 2)), line + rng.normal(0, 0.3, (n, 2))


@pytest.mark.parametrize("name", TERMS)
@settings(max_examples=15, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10_000))
def test_gradient_is_the_slope_of_the_cost(name, seed):
    span, guide = wobbly(seed)
    field = pole_field()
    _, grad = span_cost(span, guide, field, TERMS[name], TARGETS)
    h = 1e-6
    for i in range(3, len(span) - 3):
        for c in range(2):
            cell = (span[i, c] + 4.0) / 0.1 - 0.5
            if abs(cell - round(cell)) < 1e-3:
                continue  # the interpolated field has a kink between cells
            up, down = span.copy(), span.copy()
            up[i, c] += h
            down[i, c] -= h
            slope = (
                span_cost(up, guide, field, TERMS[name], TARGETS)[0]
                - span_cost(down, guide, field, TERMS[name], TARGETS)[0]
            ) / (2 * h)
            assert slope == pytest.approx(grad[i, c], rel=1e-4, abs=1e-5)


def test_fixed_points_have_no_gradient():
    span, guide = wobbly(1)
    _, grad = span_cost(span, guide, pole_field(), TERMS["all"], TARGETS)
    assert not grad[:3].any()
    assert not grad[-3:].any()
    assert grad[3:-3].any()


@pytest.mark.parametrize("name", TERMS)
def test_an_even_straight_slow_line_far_from_everything_costs_nothing(name):
    line = np.column_stack([np.linspace(-2, 2, 12), np.full(12, 3.0)])
    assert span_cost(line, line, pole_field(), TERMS[name], TARGETS)[0] == pytest.approx(
        0, abs=1e-12
    )


def test_smoothness_is_the_distance_to_the_neighbours_line():
    """Liu 2024, eq. 16, on a bend whose distances are known: one point 0.2 m beside a line."""
    line = np.column_stack([np.linspace(0, 5.5, 12), np.zeros(12)])
    line[5, 1] = 0.2
    beside = 0.2**2  # the point itself; its neighbours' lines tilt by 0.2 m in 1 m:
    tilted = 2 * (0.1**2 / (1 + 0.2**2))
    got = span_cost(line, line, pole_field(), TERMS["smooth"], TARGETS)[0]
    assert got == pytest.approx(beside + tilted, rel=1e-4)


def test_collision_cost_has_no_kink_and_the_papers_slope_inside():
    """Liu 2024, eq. 20, rounded: C1 at the threshold, slope 2 beyond the rounding."""
    values = np.tile(np.arange(60, dtype=np.float32)[:, None] * 0.1, (1, 60))
    frame = np.array([-0.05, -0.05, 0.1, 9.9])  # distance = x

    def at(x):
        q = np.tile([3.0, 3.0], (7, 1))
        q[3] = x, 3.0
        grad = np.zeros_like(q)
        cost = _kernels.collision(q, values, *frame, 1.5, 0.1, 1.0, grad)
        return cost, grad[3, 0]

    for seam in (1.5, 1.4):
        (low, slope_low), (high, slope_high) = at(seam - 1e-7), at(seam + 1e-7)
        assert low == pytest.approx(high, abs=1e-5)
        assert slope_low == pytest.approx(slope_high, abs=1e-4)
    assert at(1.0)[1] == pytest.approx(-2.0, rel=1e-4)
    assert at(1.6) == (0.0, 0.0)


def test_kernels_agree_with_their_python_selves():
    span, guide = wobbly(3)
    field = pole_field()
    weights, limits = np.array([1, 0.5, 0.02, 0.5, 0.5]), np.array([0.5, 0.9, 0.3, 1.1, 0.1])
    compiled, plain = np.empty_like(span), np.empty_like(span)
    a = _kernels.span_cost(span, guide, weights, limits, field.values, frame_of(field), compiled)
    b = _kernels.span_cost.py_func(
        span, guide, weights, limits, field.values, frame_of(field), plain
    )
    assert a == pytest.approx(b, rel=1e-6)
    np.testing.assert_allclose(compiled, plain, rtol=1e-5, atol=1e-6)


def test_field_lookup_agrees_with_the_distance_field():
    field = pole_field()
    points = np.random.default_rng(0).uniform(-3.5, 3.5, (200, 2))
    distances, gradients = field.sample(points)
    for p, d, g in zip(points, distances, gradients, strict=True):
        got = look_up(field.values, *frame_of(field), p[0], p[1])
        np.testing.assert_allclose(got, [d, *g], atol=1e-5)
