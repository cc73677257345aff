"""A GeoTIFF of ground heights (OGC 19-008r4), read by tifffile and placed by its geo keys."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.geometry.projection import MapProjection
from orchard_cli.model.arrays import Array, Points, frozen

LARGEST = 200_000_000  # bytes
MOST_PIXELS = 16_000_000
_CROP = "cut the orchard out of it, with 50 m around (gdalwarp -te, or QGIS: Clip Raster by Extent)"
_WARP = "convert it to WGS84 (gdalwarp -t_srs EPSG:4326)"
_METRES = {9001: 1.0, 9002: 0.3048, 9003: 1200 / 3937}  # EPSG's numbers of units of height
_USER_DEFINED = 32767
_NODATA, _SCALING = 42113, 42112  # GDAL's own tags


@dataclass(frozen=True, slots=True, eq=False)
class Raster:
    """Heights at the pixels' centres, and where those are."""

    file: str
    heights: Array  # (rows, columns) m; NaN where there is no data
    map_from_pixel: Array  # (2, 3): (east, north) = it @ (column, row, 1), of a pixel's centre
    projection: MapProjection

    def __post_init__(self) -> None:
        self.heights.setflags(write=False)  # 100 MB: not copied
        object.__setattr__(self, "map_from_pixel", frozen(self.map_from_pixel, (2, 3), "place"))

    def pixels(self, places_wgs84: Array) -> Points:
        """(n, 2 or 3) latitude deg, longitude deg -> (n, 2) column and row, not rounded."""
        turn, shift = self.map_from_pixel[:, :2], self.map_from_pixel[:, 2]
        off = self.projection.map_from_wgs84(places_wgs84) - shift
        return np.asarray(np.linalg.solve(turn, off.T).T, dtype=np.float64)

    def places(self, pixels: Points) -> Array:
        """(n, 2) column and row -> (n, 2) latitude deg, longitude deg."""
        turn, shift = self.map_from_pixel[:, :2], self.map_from_pixel[:, 2]
        return self.projection.wgs84_from_map(np.asarray(pixels) @ turn.T + shift)

    def at(self, places_wgs84: Array) -> Array:
        """Heights (n,) m, bilinear between pixels; NaN without data, infinite outside."""
        return _bilinear(self.heights, self.pixels(places_wgs84))


def _bilinear(heights: Array, pixels: Points) -> Array:
    last = np.array(heights.shape)[::-1] - 1  # column, row
    outside = ~((pixels >= -0.5) & (pixels <= last + 0.5)).all(axis=1)  # half a pixel is the edge's
    at = np.clip(np.nan_to_num(pixels), 0, last)
    low = np.minimum(at.astype(np.int64), np.maximum(last - 1, 0))
    (column, row), (u, v) = low.T, (at - low).T
    right, below = np.minimum(column + 1, last[0]), np.minimum(row + 1, last[1])
    found = np.zeros(len(pixels))
    for r, c, share in (
        (row, column, (1 - u) * (1 - v)), (row, right, u * (1 - v)),
        (below, column, (1 - u) * v), (below, right, u * v),
    ):  # fmt: skip
        found += np.where(share > 0, heights[r, c] * share, 0.0)
    return np.where(outside, np.inf, found)


def read(path: Path) -> Raster:
    """Read a raster of heights. Raises InputError for whatever is none."""
    try:
        import tifffile
    except ImportError as error:
        install = "pip install 'orchard-cli[terrain]'"
        raise InputError(Fault("--terrain", "needs the package tifffile", install)) from error
    _refuse_large(path)
    try:
        with tifffile.TiffFile(path) as file:
            page = file.pages[0]
            tags = dict(page.geotiff_tags or {})
            _refuse_other(page, path)
            data = np.asarray(page.asarray(maxworkers=1))
    except InputError:
        raise
    except Exception as error:  # whatever a broken file makes of the parser
        what = f"is no GeoTIFF that can be read: {str(error).splitlines()[0][:100] or 'broken'}"
        raise InputError(Fault(path.name, what, "save it again as GeoTIFF")) from error
    heights = _metres(data, page, tags, path)
    return Raster(path.name, heights, _placed(tags, path), _projection(tags, path))


def _refuse_large(path: Path) -> None:
    if not path.is_file():
        what = "is no regular file" if path.exists() else "is no file"
        raise InputError(Fault(str(path), what, "give the path of a GeoTIFF"))
    if path.stat().st_size > LARGEST:
        raise InputError(Fault(str(path), f"too large, {LARGEST / 1e6:.0f} MB is the most", _CROP))


def _refuse_other(page: Any, path: Path) -> None:
    """Before the pixels are unpacked."""
    if page.samplesperpixel != 1 or len(page.shape) != 2:
        what = f"has {page.samplesperpixel} bands, heights have one: it is a picture"
        raise InputError(Fault(path.name, what, "give a terrain model (DTM)"))
    if page.shape[0] * page.shape[1] > MOST_PIXELS:
        what = f"has {page.shape[1]} x {page.shape[0]} pixels"
        raise InputError(Fault(path.name, what, _CROP))
    if page.dtype is None or np.dtype(page.dtype).kind not in "iuf":
        raise InputError(Fault(path.name, f"holds {page.dtype}, no heights", "save it as Float32"))
    scaling = page.tags.get(_SCALING)
    if scaling is not None and 'role="scale"' in str(scaling.value).lower():
        what = "holds scaled numbers"
        raise InputError(Fault(path.name, what, "write out the heights (gdal_translate -unscale)"))


def _metres(data: Array, page: Any, tags: dict[str, Any], path: Path) -> Array:
    heights = data.astype(np.float64)
    nodata = page.tags.get(_NODATA)
    if nodata is not None:
        try:
            missing = float(str(nodata.value).strip(" \0"))
        except ValueError as error:
            what = f"tells no number for no data: {nodata.value!r}"
            raise InputError(Fault(path.name, what, "set it (gdal_translate -a_nodata)")) from error
        heights[data == np.array(missing).astype(data.dtype)] = np.nan
    unit = int(tags.get("VerticalUnitsGeoKey", 9001))
    if unit not in _METRES:
        raise InputError(Fault(path.name, f"heights in unit EPSG:{unit}", "convert them to metres"))
    scaled: Array = heights * _METRES[unit]
    return scaled


def _placed(tags: dict[str, Any], path: Path) -> Array:
    """(2, 3) of the pixels' centres, by the tie point or the transformation."""
    turned = tags.get("ModelTransformation")
    scale, tie = tags.get("ModelPixelScale"), tags.get("ModelTiepoint")
    if turned is not None:
        placed = np.asarray(turned, dtype=np.float64).reshape(4, 4)[[0, 1]][:, [0, 1, 3]]
    elif scale is not None and tie is not None and np.size(tie) == 6:
        (sx, sy), (column, row, _, x, y, _) = np.ravel(scale)[:2], np.ravel(tie)
        placed = np.array([[sx, 0.0, x - column * sx], [0.0, -sy, y + row * sy]])
    else:
        raise InputError(Fault(path.name, "does not tell where it lies", "give a GeoTIFF"))
    if int(tags.get("GTRasterTypeGeoKey", 1)) != 2:  # a pixel is an area: its centre is meant
        placed = placed + np.column_stack([np.zeros((2, 2)), placed[:, :2] @ [0.5, 0.5]])
    if not np.isfinite(placed).all() or not abs(np.linalg.det(placed[:, :2])) > 0:
        raise InputError(Fault(path.name, "tells no place that can be used", "save it again"))
    return placed


def _projection(tags: dict[str, Any], path: Path) -> MapProjection:
    model = int(tags.get("GTModelTypeGeoKey", 0))
    key = {1: "ProjectedCSTypeGeoKey", 2: "GeographicTypeGeoKey"}.get(model)
    code = int(tags.get(key, 0)) if key else 0
    if not 0 < code < _USER_DEFINED:
        raise InputError(Fault(path.name, "names no reference system by its EPSG number", _WARP))
    try:
        return MapProjection.of_epsg(code)
    except ValueError as error:
        raise InputError(Fault(path.name, str(error), _WARP)) from error
