"""What the distance field promises."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.ndimage import distance_transform_edt

from orchard_cli.mapping import Band, _kernels, distance_field

CELL = 0.1


def band(occupied, origin=(3.0, -2.0)):
    return Band(np.array(origin), CELL, occupied, np.ones_like(occupied), 3.0, 4.0)


fields = arrays(
    bool, st.tuples(st.integers(2, 25), st.integers(2, 25)),
    elements=st.integers(0, 9).map(lambda n: n == 0), fill=st.just(False),
)  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(fields, st.floats(0.05, 3.0))
def test_distances_are_exact_up_to_the_reach(occupied, reach):
    field = distance_field(band(occupied), reach)
    exact = distance_transform_edt(~occupied) * CELL if occupied.any() else np.inf
    np.testing.assert_allclose(
        field.values, np.minimum(exact, field.reach) + 0 * field.values, atol=1e-6
    )
    assert reach <= field.reach + 1e-9 < reach + CELL + 2e-9


@settings(max_examples=60, deadline=None)
@given(fields, st.integers(0, 10_000))
def test_the_gradient_is_that_of_the_interpolated_distance(occupied, seed):
    field = distance_field(band(occupied), 0.8)
    rng = np.random.default_rng(seed)
    size = CELL * np.array(occupied.shape)
    points = field.origin_site + rng.uniform(-0.3, 0.3 + size, (40, 2))
    step = 1e-6
    phase = np.mod((points - field.origin_site) / CELL - 0.5, 1.0)
    points = points[((phase > 1e-4) & (phase < 1 - 1e-4)).all(axis=1)]  # off the seams
    for axis, shift in enumerate(np.eye(2) * step):
        slope = (field.at(points + shift) - field.at(points - shift)) / (2 * step)
        np.testing.assert_allclose(field.gradient(points)[:, axis], slope, atol=1e-6)


@settings(max_examples=30, deadline=None)
@given(fields, st.integers(0, 10_000))
def test_the_distance_never_changes_faster_than_one_moves_along_an_axis(occupied, seed):
    field = distance_field(band(occupied), 1.0)
    inside = np.random.default_rng(seed).uniform(
        0.05, CELL * np.array(occupied.shape) - 0.05, (50, 2)
    )
    assert np.abs(field.gradient(field.origin_site + inside)).max() <= 1.0 + 1e-5


def test_outside_the_band_the_distance_is_the_reach():
    field = distance_field(band(np.ones((5, 5), dtype=bool)), 0.7)
    far = np.array([[2.5, -1.8], [4.0, -1.8], [3.2, -5.0], [1e6, 1e6], [-1e6, 0.0]])
    np.testing.assert_allclose(field.at(far), field.reach)
    np.testing.assert_array_equal(field.gradient(far), 0.0)


def test_values_stand_at_the_cells_centres():
    occupied = np.zeros((9, 7), dtype=bool)
    occupied[4, 2] = True
    field = distance_field(band(occupied, origin=(10.0, 20.0)), 1.0)
    centre = np.array([[10.45, 20.25]])
    assert field.at(centre)[0] == pytest.approx(0.0, abs=1e-6)
    assert field.at(centre + np.array([0.3, 0.0]))[0] == pytest.approx(0.3, abs=1e-6)
    assert field.at(centre + np.array([0.0, 0.4]))[0] == pytest.approx(0.4, abs=1e-6)


@settings(max_examples=15, deadline=None)
@given(fields, st.integers(1, 12))
def test_the_distance_kernel_does_what_its_python_says(occupied, reach):
    compiled, interpreted = (np.empty(occupied.shape, dtype=np.float32) for _ in range(2))
    _kernels.squared_distance(band(occupied).occupied, reach, compiled)
    _kernels.squared_distance.py_func(occupied, reach, interpreted)
    np.testing.assert_array_equal(compiled, interpreted)


def test_a_band_cannot_be_written_to():
    with pytest.raises(ValueError, match="read-only"):
        band(np.zeros((3, 3), dtype=bool)).occupied[0, 0] = True


@pytest.mark.parametrize("reach", [0.0, -1.0, np.inf, np.nan])
def test_an_impossible_reach_is_refused(reach):
    with pytest.raises(ValueError, match="reach"):
        distance_field(band(np.zeros((3, 3), dtype=bool)), reach)
