"""Laws of the place along the route."""

from __future__ import annotations

import made_flights as made
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.analysis.along import places


@settings(max_examples=30, deadline=None, derandomize=True)
@given(speed=st.floats(0.2, 5.0), rows=st.integers(1, 4), side=st.floats(-1.5, 1.5))
def test_the_same_place_is_found_whatever_the_speed(speed, rows, side):
    """Beside the line, past neighbouring rows, to the end: never a jump to another row."""
    corners = made.corners(rows)
    flown = np.arange(0.0, made.length(corners), speed / 10)
    points = made.along(corners, flown)
    points[:, 1] += side
    found = places(corners, points)
    assert (np.diff(found) >= 0).all()
    assert np.abs(found - flown).max() <= 2 * abs(side) + 0.2  # at a corner both legs are near


def test_who_turns_back_keeps_the_farthest_place():
    corners = made.corners(1)
    there_and_back = np.concatenate([np.arange(0.0, 10.0, 0.1), np.arange(10.0, 6.0, -0.1)])
    found = places(corners, made.along(corners, there_and_back))
    assert found[-1] == found.max()
    assert abs(found.max() - 10.0) < 0.2
