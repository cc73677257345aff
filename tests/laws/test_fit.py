"""The Π's curve: corners cut within the bound, straights straight, curvature calm."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import make_lsq_spline

from orchard_cli.motion.fit import (
    REACH,
    SPACING,
    distances,
    evaluate,
    fit_rounded,
    fit_spline,
    lengths_of,
    rounded,
    samples,
)


def pi_route(starts, ends, spacing, height=3.5):
    """The Π's corners over rows from `starts` to `ends`, `spacing` apart."""
    points = []
    for k, (a, b) in enumerate(zip(starts, ends, strict=True)):
        row = [(a, k * spacing, height), (b, k * spacing, height)]
        points += row if k % 2 == 0 else row[::-1]
    return np.array(points, dtype=float)


@st.composite
def routes(draw):
    n = draw(st.integers(2, 5))
    shift = st.floats(-8, 8)
    starts = [draw(shift) for _ in range(n)]
    ends = [30 + draw(shift) for _ in range(n)]
    return pi_route(starts, ends, draw(st.floats(2, 8)))


@given(routes(), st.floats(0.2, 1.5))
@settings(max_examples=25, deadline=None, derandomize=True)
def test_no_corner_is_cut_by_more_than_asked(route, cut):
    path, spline = fit_rounded(route, cut, round(2 * lengths_of(route)[-1]))
    assert distances(route[1:-1], samples(spline)).max() <= cut + 1e-6
    assert (path.cuts <= cut + 1e-9).all()


@given(routes(), st.floats(0.2, 1.0))
@settings(max_examples=25, deadline=None, derandomize=True)
def test_outside_the_corners_the_curve_stays_within_a_centimetre_of_the_straights(route, cut):
    _, spline = fit_rounded(route, cut, round(2 * lengths_of(route)[-1]))
    curve = samples(spline)
    to_corner = np.linalg.norm(curve[:, None] - route[None, 1:-1], axis=2).min(axis=1)
    straight = curve[to_corner > REACH * cut + 0.5]
    assert distances(straight[::15], route).max() < 0.01


def test_spline_starts_and_ends_on_the_route_along_its_rows():
    route = pi_route([0, 1], [30, 32], 6.0)
    _, spline = fit_rounded(route, 0.5, 130)
    control = spline.control_points_site
    assert control[[0, -1]] == pytest.approx(route[[0, -1]], abs=1e-9)
    first, last = control[1] - control[0], control[-1] - control[-2]
    assert first / np.linalg.norm(first) == pytest.approx([1, 0, 0], abs=1e-3)
    assert last / np.linalg.norm(last) == pytest.approx([-1, 0, 0], abs=1e-3)


def test_the_fit_is_that_of_the_slower_qr_factors_to_a_nanometre():
    route = pi_route([0, 3, -2], [60, 58, 63], 4.0)
    path = rounded(route, 0.5).points_site
    spline = fit_spline(path, round(2 * lengths_of(path)[-1]))
    weights = np.ones(len(path))
    weights[[0, -1]] = 1e4
    exact = make_lsq_spline(lengths_of(path), path, spline.knots, k=3, w=weights, method="qr")
    assert spline.control_points_site == pytest.approx(exact.c, abs=1e-9)


def test_control_points_are_half_a_metre_apart_on_straights():
    route = pi_route([0, 0], [30, 30], 6.0)
    _, spline = fit_rounded(route, 0.5, 2 * 66)
    inner = spline.control_points_site[5:40]
    assert np.diff(inner[:, 0]) == pytest.approx(0.5, abs=0.02)


def test_curvature_of_a_right_angle_is_continuous_and_near_its_least():
    """0.414 / cut is an arc's, whose curvature steps; the ramps may cost 15% more."""
    route = np.array([[0.0, 0, 3], [20, 0, 3], [20, 20, 3]])
    _, spline = fit_rounded(route, 0.5, 80)
    u = np.linspace(0, spline.knots[-1], 8001)
    curve = evaluate(spline, u)
    step = u[1]
    d1, d2 = (
        np.gradient(curve, step, axis=0),
        np.gradient(np.gradient(curve, step, axis=0), step, axis=0),
    )
    curvature = np.cross(d1, d2)[:, 2] / np.linalg.norm(d1, axis=1) ** 3
    inner = curvature[10:-10]
    assert inner.max() < 1.15 * (math.sqrt(2) - 1) / 0.5
    assert inner.min() > -0.03  # it never bends the other way by more than a radius of 33 m
    assert np.abs(np.diff(inner)).max() < 0.02


@given(routes(), st.floats(0.05, 3.0))
@settings(max_examples=25, deadline=None, derandomize=True)
def test_rounded_path_has_short_even_steps_and_turns_gently(route, cut):
    path = rounded(route, cut)
    steps = np.linalg.norm(np.diff(path.points_site, axis=0), axis=1)
    assert steps.max() <= SPACING * 1.01
    assert (steps > 0).all()
    assert path.points_site[[0, -1]] == pytest.approx(route[[0, -1]])
    passed = np.array(
        [
            np.interp(path.corner_lengths, lengths_of(path.points_site), c)
            for c in path.points_site.T
        ]
    ).T
    assert np.linalg.norm(passed - route[1:-1], axis=1) == pytest.approx(path.cuts, abs=0.01)


def test_rounding_works_in_any_plane():
    flat = np.array([[0.0, 0, 0], [10, 0, 0], [10, 8, 0]])
    turn = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    a, b = rounded(flat, 0.5).points_site @ turn.T, rounded(flat @ turn.T, 0.5).points_site
    assert np.abs(a - b).max() < 1e-9


@pytest.mark.parametrize(
    ("corners", "cut"),
    [
        ([[0, 0, 0], [5, 0, 0], [0, 0, 0]], 0.5),
        ([[0, 0, 0], [0, 0, 0], [5, 0, 0]], 0.5),
        ([[0, 0, 0], [5, 0, 0], [5, 5, 0]], 0.0),
        ([[0, 0, 0], [5, 0, 0], [5, 5, 0]], math.nan),
    ],
)
def test_what_cannot_be_rounded_is_refused(corners, cut):
    with pytest.raises(ValueError, match=r"."):
        rounded(np.array(corners, dtype=float), cut)


def test_spline_of_a_straight_line_is_the_line():
    line = np.linspace([0, 0, 2], [10, 5, 3], 400)
    spline = fit_spline(line, 20)
    assert distances(samples(spline), line).max() < 1e-9


@pytest.mark.parametrize("stagger", [0.0, 0.5, -0.5])
def test_a_turn_back_on_a_short_leg_is_one_bend_wider_than_two(stagger):
    """Six metres between two rows: no straight and no dip of the curvature between its corners."""
    route = pi_route([0, 0], [30, 30 + stagger], 6.0)
    one, two = (rounded(route, 1.6, merge=merge) for merge in (True, False))
    assert (one.cuts <= 1.6 + 1e-9).all()
    bends = [_curvature(path.points_site) for path in (one, two)]
    assert bends[0].max() < 0.85 * bends[1].max()
    assert one.total < two.total
    high = np.flatnonzero(bends[0] > 0.9 * bends[0].max())
    assert (np.diff(high) == 1).all()
    assert np.abs(np.diff(bends[0])).max() < 0.05


def test_corners_far_apart_or_cut_little_are_rounded_one_by_one():
    for spacing, cut in ((6.0, 0.5), (12.0, 1.5)):
        route = pi_route([0, 0], [30, 30], spacing)
        one, two = (rounded(route, cut, merge=merge) for merge in (True, False))
        assert one.points_site.tobytes() == two.points_site.tobytes()


def _curvature(path):
    """1/m along a path (n, 3), every 0.1 m."""
    lengths = lengths_of(path)
    even = np.arange(0.0, lengths[-1], 0.1)
    ways = np.diff(np.column_stack([np.interp(even, lengths, axis) for axis in path.T]), axis=0)
    return np.abs(np.diff(np.unwrap(np.arctan2(ways[:, 1], ways[:, 0])))) / 0.1
