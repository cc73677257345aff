"""Rows found in bare trees: right within the limits that docs/survey.md states, doubted beyond."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_orchards import made, share_right

from orchard_cli.survey.finding import find_rows


def as_made(found, labels):
    return found is not None and len(found.rows) == labels.max() + 1


@given(
    st.integers(0, 10_000), st.integers(3, 8), st.sampled_from([3.5, 5.0, 7.0]),
    st.sampled_from([0.0, 0.3]), st.sampled_from([None, 150.0, 400.0]),
    st.sampled_from([0.0, 0.2]),
)  # fmt: skip
@settings(max_examples=6, deadline=None, derandomize=True)
def test_rows_are_right_with_little_noise(seed, rows, spacing, cep, radius, missing):
    places, labels, direction = made(
        seed, rows=rows, trees=18, spacing=spacing, cep=cep, radius=radius, missing=missing
    )
    found = find_rows(places)
    assert as_made(found, labels)
    assert share_right(found, labels) >= 0.98
    assert found.scatter < 0.6
    off = (found.direction - direction + math.pi / 2) % math.pi - math.pi / 2
    assert abs(off) < math.radians(3)
    assert sorted(np.concatenate([*found.rows, found.apart])) == list(range(len(places)))


@pytest.mark.parametrize("seed", range(2))
def test_rows_six_metres_apart_are_found_in_gps_of_a_metre_and_a_half(seed):
    places, labels, _ = made(seed, spacing=6.0, cep=1.5)
    found = find_rows(places)
    assert as_made(found, labels)
    assert share_right(found, labels) > 0.93


@pytest.mark.parametrize("seed", range(2))
def test_where_noise_drowns_the_rows_they_are_not_trusted(seed):
    places, _, _ = made(seed, spacing=3.0, cep=2.0)
    found = find_rows(places)
    assert found is None or found.why_not


def test_a_tree_between_rows_is_in_none():
    places, labels, direction = made(3, spacing=6.0)
    across = np.array([-math.sin(direction), math.cos(direction)])
    found = find_rows(np.vstack([places, across * 15.0]))  # half way between two rows
    assert as_made(found, labels)
    assert found.apart.tolist() == [len(places)]


def test_a_known_heading_settles_which_way_the_rows_of_a_square_grid_run():
    x, y = np.meshgrid(np.arange(12) * 4.0, np.arange(12) * 4.0)
    grid = np.column_stack([x.ravel(), y.ravel()])
    assert find_rows(grid).why_not
    one, other = (find_rows(grid, towards=t) for t in (0.0, math.pi / 2))
    assert one.direction % math.pi == pytest.approx(0.0, abs=1e-6) or one.direction > 3.14
    assert other.direction == pytest.approx(math.pi / 2)
    assert [len(f.rows) for f in (one, other)] == [12, 12]
    assert not one.why_not
    assert not other.why_not
