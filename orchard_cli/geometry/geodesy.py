"""Between the site frame and WGS84, by the topocentric frame of the site's origin.

Heights are measured from whatever the origin's height is measured from. An origin above mean sea
level is placed as if its height were ellipsoidal: a geoid 50 m away turns 1 km into 8 mm of
horizontal error and leaves height differences alone.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from pyproj import Geod, Transformer

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.site import SiteOrigin

from .frames import enu_from_site

_ELLIPSOID = Geod(ellps="WGS84")
_EARTH = 6.371e6  # m, mean radius


@lru_cache(maxsize=8)
def _enu_from_wgs84(latitude: float, longitude: float, height: float) -> Transformer:
    """Degrees, degrees and metres to metres east, north and up."""
    return Transformer.from_pipeline(
        "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad "
        "+step +proj=cart +ellps=WGS84 "
        f"+step +proj=topocentric +ellps=WGS84 "
        f"+lat_0={latitude!r} +lon_0={longitude!r} +h_0={height!r}"
    )


def _transformer(origin: SiteOrigin) -> Transformer:
    return _enu_from_wgs84(
        float(origin.latitude_deg), float(origin.longitude_deg), float(origin.height)
    )


def site_from_wgs84(origin: SiteOrigin, places_wgs84: Array) -> Points:
    """(n, 3) latitude deg, longitude deg, height m → (n, 3) m in the site frame."""
    latitude, longitude, height = np.asarray(places_wgs84, dtype=np.float64).T
    enu = np.column_stack(_transformer(origin).transform(longitude, latitude, height))
    points: Points = enu @ enu_from_site(origin.heading)
    return points


def wgs84_from_site(origin: SiteOrigin, points_site: Points) -> Array:
    """(n, 3) m in the site frame → (n, 3) latitude deg, longitude deg, height m."""
    enu = np.asarray(points_site, dtype=np.float64) @ enu_from_site(origin.heading).T
    east, north, up = enu.T
    back = _transformer(origin).transform(east, north, up, direction="INVERSE")
    longitude, latitude, height = back
    return np.column_stack([latitude, longitude, height])


def wgs84_by_geodesics(origin: SiteOrigin, points_site: Points) -> Array:
    """As `wgs84_from_site`, by walking a geodesic from the origin to each point (n, 3) m.

    Good to some millimetres within a kilometre, and made without any rotation: a check on signs.
    """
    points = np.asarray(points_site, dtype=np.float64)
    bearings = origin.heading - np.arctan2(points[:, 1], points[:, 0])
    lower = 1.0 + (origin.height + points[:, 2]) / _EARTH
    n = len(points)
    longitude, latitude, _ = _ELLIPSOID.fwd(
        np.full(n, origin.longitude_deg),
        np.full(n, origin.latitude_deg),
        np.degrees(bearings),
        np.hypot(points[:, 0], points[:, 1]) / lower,
    )
    return np.column_stack([latitude, longitude, origin.height + points[:, 2]])


def apart(a_wgs84: Array, b_wgs84: Array) -> Array:
    """(n,) m along the ellipsoid between two lists (n, 2 or 3) of latitude, longitude in deg."""
    a, b = np.asarray(a_wgs84, dtype=np.float64), np.asarray(b_wgs84, dtype=np.float64)
    _, _, metres = _ELLIPSOID.inv(a[:, 1], a[:, 0], b[:, 1], b[:, 0])
    return np.asarray(metres)
