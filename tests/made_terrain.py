"""Tiny GeoTIFFs of made ground, written by tifffile."""

from __future__ import annotations

import numpy as np
import tifffile

from orchard_cli.geometry.projection import MapProjection

LATITUDE, LONGITUDE = 23.45, 113.2  # a place in UTM zone 49 north
UTM = 32649
SITE = f"""
[site]
latitude_deg = {LATITUDE}
longitude_deg = {LONGITUDE}
height_m = 20.0
heading_deg = HEADING
[flight]
height_m = 3.5
"""
ROWS = """
[[row]]
gaps_m = [3.0, 3.0, 3.0, 3.0, 3.0]
tree_height_m = 2.0
[[row]]
distance_m = 6.0
gaps_m = [3.0, 3.0, 3.0, 3.0, 3.0]
tree_height_m = 2.0
"""


def survey_text(heading=90.0, more="", flight=""):
    return SITE.replace("HEADING", str(heading)) + flight + more + ROWS


def plane(east, north, level=20.0):
    """Ground that rises by `east` m per m eastwards and `north` m per m northwards."""
    return lambda e, n: level + east * e + north * n


def write(
    path, height, *, epsg=UTM, reach=100.0, step=2.0, point=False, dtype=np.float32, nodata=None,
    unit=None, **options,
):  # fmt: skip
    """A GeoTIFF of height(east, north), m from the site's origin, over a square about it.

    With `epsg` 4326 the pixels are degrees. `point`: a pixel's place is its centre.
    """
    centre = MapProjection.of_epsg(epsg).map_from_wgs84(np.array([[LATITUDE, LONGITUDE]]))[0]
    per_metre = np.array([1.0, 1.0])
    if epsg == 4326:
        per_metre = 1 / (111_320.0 * np.array([np.cos(np.radians(LATITUDE)), 0.99505]))
    count = int(2 * reach / step)
    shift = 0.0 if point else 0.5
    column, row = np.meshgrid(np.arange(count) + shift, np.arange(count) + shift)
    east, north = column * step - reach, reach - row * step
    heights = height(east, north).astype(dtype)
    scale = step * per_metre
    left, top = centre + np.array([-reach, reach]) * per_metre
    keys = [(1024, 2 if epsg == 4326 else 1), (1025, 2 if point else 1)]
    keys.append((2048 if epsg == 4326 else 3072, epsg))
    keys += [] if unit is None else [(4099, unit)]
    flat = [1, 1, 0, len(keys), *(n for key, value in keys for n in (key, 0, 1, value))]
    tags = [
        (33550, "d", 3, (*scale, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, left, top, 0.0), True),
        (34735, "H", len(flat), tuple(flat), True),
    ]
    if nodata is not None:
        tags.append((42113, "s", 0, str(nodata), True))
    tifffile.imwrite(path, heights, extratags=tags, metadata=None, **options)
    return path
