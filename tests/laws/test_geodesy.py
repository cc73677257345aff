"""The site frame's place on the earth: round trips, and directions that a compass agrees with."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pyproj import Geod

from orchard_cli.geometry.frames import enu_from_site, ned_from_site
from orchard_cli.geometry.geodesy import site_from_wgs84, wgs84_from_site
from orchard_cli.model.site import HeightReference, SiteOrigin

origins = st.builds(
    SiteOrigin,
    latitude_deg=st.floats(-89.9, 89.9),
    longitude_deg=st.floats(-180, 180),
    height=st.floats(-400, 5000),
    height_reference=st.sampled_from(HeightReference),
    heading=st.floats(-math.pi, math.pi),
)
points = st.lists(
    st.tuples(st.floats(-2000, 2000), st.floats(-2000, 2000), st.floats(-100, 100)),
    min_size=1,
    max_size=5,
).map(np.array)


@given(origins, points)
@settings(max_examples=60, deadline=None, derandomize=True)
def test_site_to_wgs84_and_back_is_within_a_millimetre(origin, points_site):
    back = site_from_wgs84(origin, wgs84_from_site(origin, points_site))
    assert np.abs(back - points_site).max() < 1e-3


@pytest.mark.parametrize("heading_deg", [0.0, 30.0, 90.0, 200.0, 315.0])
def test_x_points_along_the_compass_heading_and_y_to_its_left(heading_deg):
    origin = SiteOrigin(23.45, 113.13, 0.0, HeightReference.ELLIPSOID, math.radians(heading_deg))
    places = wgs84_from_site(origin, np.array([[100.0, 0, 0], [0, 100.0, 0], [0, 0, 7.0]]))
    geod = Geod(ellps="WGS84")
    for place, bearing in ((places[0], heading_deg), (places[1], heading_deg - 90)):
        azimuth, _, length = geod.inv(113.13, 23.45, place[1], place[0])
        assert math.cos(math.radians(azimuth - bearing)) > 1 - 1e-9
        assert length == pytest.approx(100.0, abs=2e-3)
    assert places[2] == pytest.approx([23.45, 113.13, 7.0], abs=1e-7)


@given(st.floats(-10, 10))
@settings(derandomize=True)
def test_frames_are_rotations_that_agree_with_each_other(heading):
    ned, enu = ned_from_site(heading), enu_from_site(heading)
    ned_from_enu = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
    assert np.allclose(ned_from_enu @ enu, ned)
    assert np.linalg.det(ned) == pytest.approx(1)
    assert np.allclose(ned @ ned, np.eye(3))
