"""The way home."""

import numpy as np
import pytest

from orchard_cli.flight.trail import Trail


def flown(points):
    trail = Trail()
    for point in points:
        trail.add(np.array(point, dtype=float))
    return trail


def test_home_leads_back_over_the_flown_way():
    out = [(x, 0.0, 3.0) for x in np.arange(0, 10.1, 0.1)]
    out += [(10.0, y, 3.0) for y in np.arange(0, 6.1, 0.1)]
    trail = flown(out)
    home = trail.home(np.array([10.0, 6.0, 3.0]))
    assert home[0] == pytest.approx([10, 6, 3])
    assert home[-1] == pytest.approx([0, 0, 3])
    way = np.array(out)
    off = [np.linalg.norm(way - p, axis=1).min() for p in home]
    assert max(off) < 0.6
    assert trail.length == pytest.approx(16.0, abs=0.5)


def test_home_from_the_start_is_where_one_is():
    home = flown([(1.0, 2.0, 3.0)]).home(np.array([1.0, 2.0, 3.0]))
    assert len(home) >= 2
    assert np.linalg.norm(home - [1, 2, 3], axis=1).max() < 0.01


def test_a_trail_that_came_straight_back_still_leads_home():
    there = [(x, 0.0, 3.0) for x in np.arange(0, 8.1, 0.25)]
    trail = flown(there + there[::-1] + there)
    assert trail.home(np.array([8.0, 0.0, 3.0]))[-1] == pytest.approx([0, 0, 3])
