"""An orchard is put onto the ground of a terrain raster.

Heights count from the raster's own height at the origin, so that neither its datum nor the survey's
height above the sea can tilt or lift the flight.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.geometry.geodesy import site_from_wgs84, wgs84_from_site
from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.site import KnownObstacle, Orchard, SiteOrigin
from orchard_cli.model.terrain import Terrain

from . import geotiff
from .geotiff import Raster
from .load import Survey

FINEST, COARSEST = 0.5, 5.0  # m between nodes
MOST_NODES = 20_000  # 0.2 MB in a mission
MOST_POSTS = 4_000_000  # of the raster within the area
DISAGREE = 1.0  # m between what a survey measured and the raster
STRANGE = 10.0  # m between the two heights of the origin that is worth a word
_LOWEST, _HIGHEST = -500.0, 9_000.0  # m
_MICRONS = 6


def on_terrain(survey: Survey, path: Path, margin: float, places: Points) -> Survey:
    """The survey with the raster's ground under trees and obstacles.

    `margin` m round all trees and `places` (n, 2) are covered. Raises InputError where the raster
    does not reach, has no data, or is another ground than the one that the crew measured.
    """
    raster, orchard = geotiff.read(path), survey.orchard
    here = _at_origin(raster, orchard.origin)
    trunks = np.concatenate([row.trunks_site for row in orchard.rows])
    stands = np.array([o.position_site for o in orchard.obstacles]).reshape(-1, 2)
    needed = np.concatenate([trunks, stands, places.reshape(-1, 2)])
    terrain = _grid(raster, orchard.origin, here, needed, margin)
    measured = any(row.ground.any() for row in orchard.rows)
    rows = tuple(replace(row, ground=_ground(terrain, row.trunks_site)) for row in orchard.rows)
    faults = [
        _differs(f"row {k}, tree {t + 1}", float(told.ground[t]), float(row.ground[t]))
        for k, (told, row) in enumerate(zip(orchard.rows, rows, strict=True), 1)
        for t in [int(np.abs(told.ground - row.ground).argmax())]
        if measured and abs(told.ground[t] - row.ground[t]) > DISAGREE
    ]
    obstacles, more = _obstacles(orchard, survey.tables, terrain)
    if faults or more:
        raise InputError(faults + more)
    return replace(
        survey,
        orchard=replace(orchard, rows=rows, obstacles=obstacles, terrain=terrain),
        remarks=_remarks(raster, terrain, orchard.origin, here),
    )


def _at_origin(raster: Raster, origin: SiteOrigin) -> float:
    """The raster's height of the ground at the origin, m."""
    place = np.array([[origin.latitude_deg, origin.longitude_deg]])
    height = float(raster.at(place)[0])
    _refuse(raster, np.array([height]), ["the first tree"], place)
    return height


def _grid(
    raster: Raster, origin: SiteOrigin, here: float, needed: Points, margin: float
) -> Terrain:
    low, high = needed.min(axis=0) - margin, needed.max(axis=0) + margin
    step = max(
        FINEST, min(COARSEST, _spacing(raster, origin)), math.sqrt(np.prod(high - low) / MOST_NODES)
    )
    step = math.ceil(step * 100) / 100
    count = np.ceil((high - low) / step).astype(int) + 1
    corner = np.round(low, 2)
    x, y = (corner[k] + step * np.arange(count[k]) for k in (0, 1))
    nodes = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    places = wgs84_from_site(origin, np.column_stack([nodes, np.zeros(len(nodes))]))
    heights = raster.at(places)
    names = [f"({px:.0f}, {py:.0f}), within the {margin:.0f} m round the trees" for px, py in nodes]
    _refuse(raster, heights, names, places)
    terrain = Terrain(corner, step, _site_z(origin, places, heights - here).reshape(count))
    return _over_all(terrain, raster, origin, here)


def _site_z(origin: SiteOrigin, places_wgs84: Array, above: Array) -> Array:
    """z (n,) m in the site frame of ground `above` (n,) m the origin's: the earth is round."""
    raised = np.column_stack([places_wgs84[:, :2], origin.height + above])
    return np.asarray(site_from_wgs84(origin, raised)[:, 2])


def _spacing(raster: Raster, origin: SiteOrigin) -> float:
    """m between pixels near the origin, the closer way."""
    pixel = raster.pixels(np.array([[origin.latitude_deg, origin.longitude_deg]]))
    around = raster.places(pixel + np.array([[0, 0], [1, 0], [0, 1]]))
    site = site_from_wgs84(origin, np.column_stack([around, np.full(3, origin.height)]))
    return float(np.linalg.norm(site[1:, :2] - site[0, :2], axis=1).min())


def _over_all(terrain: Terrain, raster: Raster, origin: SiteOrigin, here: float) -> Terrain:
    """Raised where a pixel of the raster stands above the grid: it never tells too little."""
    a, b = terrain.corner_site, terrain.far_corner_site
    corners = np.array([[*a, 0.0], [a[0], b[1], 0.0], [*b, 0.0], [b[0], a[1], 0.0]])
    pixels = raster.pixels(wgs84_from_site(origin, corners))
    last = np.array(raster.heights.shape)[::-1] - 1
    first = np.clip(np.floor(pixels.min(axis=0)), 0, last).astype(int)
    until = np.clip(np.ceil(pixels.max(axis=0)), 0, last).astype(int) + 1
    if np.prod(until - first) > MOST_POSTS:
        mend = "thin it to 0.5 m or so (gdalwarp -tr 0.5 0.5 -r max)"
        raise InputError(Fault(raster.file, f"has {np.prod(until - first)} pixels here", mend))
    columns, rows = np.meshgrid(*(np.arange(p, q) for p, q in zip(first, until, strict=True)))
    heights = raster.heights[rows, columns].ravel()
    posts = raster.places(np.column_stack([columns.ravel(), rows.ravel()]))
    z = _site_z(origin, posts, heights - here)
    site = site_from_wgs84(origin, np.column_stack([posts, np.full(len(posts), origin.height)]))
    kept = (site[:, :2] >= a).all(axis=1) & (site[:, :2] <= b).all(axis=1) & np.isfinite(z)
    lack = z[kept] - terrain.ground(site[kept])
    raised = np.zeros(terrain.heights.shape)
    for i, j, share in terrain.nodes(site[kept]):
        np.maximum.at(raised, (i, j), np.where(share > 0, lack, 0.0))
    return replace(terrain, heights=np.round(terrain.heights + raised, 3))


def _refuse(raster: Raster, heights: Array, names: list[str], places_wgs84: Array) -> None:
    """Raises InputError where (n,) heights are missing, outside, or of no place on earth."""
    for bad, what, mend in (
        (np.isinf(heights), "does not reach", "take a larger piece of the terrain"),
        (np.isnan(heights), "has no data at", "fill its gaps (gdal_fillnodata), or take another"),
        (
            (heights < _LOWEST) | (heights > _HIGHEST),
            "tells no height of the earth at",
            "declare its value for no data (gdal_translate -a_nodata)",
        ),
    ):
        if bad.any():
            k = int(bad.argmax())
            where = f"{names[k]}: {places_wgs84[k, 0]:.6f} {places_wgs84[k, 1]:.6f}"
            raise InputError(Fault(raster.file, f"{what} {where}", mend))


def _ground(terrain: Terrain, places: Points) -> Array:
    return np.round(terrain.ground(places), _MICRONS) + 0.0


def _differs(where: str, told: float, found: float) -> Fault:
    what = f"the survey says ground_m = {told:.2f}, the terrain {found:.2f}"
    return Fault(where, what, "leave out ground_m, or --terrain; one of them is another place")


def _obstacles(
    orchard: Orchard, said: Mapping[str, Any], terrain: Terrain
) -> tuple[tuple[KnownObstacle, ...], list[Fault]]:
    """Each stands on the terrain; one whose ground was measured has to agree with it."""
    moved, faults = [], []
    for k, obstacle in enumerate(orchard.obstacles):
        table = said["obstacle"][k]
        told, found = (
            table.get("ground_m"),
            float(_ground(terrain, obstacle.position_site[None])[0]),
        )
        if told is not None and abs(told - found) > DISAGREE:
            faults.append(_differs(f"obstacle {k + 1}, {obstacle.name}", float(told), found))
        moved.append(replace(obstacle, top=obstacle.top - float(told or 0.0) + found))
    return tuple(moved), faults


def _remarks(raster: Raster, terrain: Terrain, origin: SiteOrigin, here: float) -> tuple[str, ...]:
    low, high = float(terrain.heights.min()), float(terrain.heights.max())
    told = [
        f"ground from {raster.file} ({raster.projection.name}): {low:+.1f} to {high:+.1f} m about "
        f"that at the first tree, a node every {terrain.step:g} m"
    ]
    if abs(here - origin.height) > STRANGE:
        told.append(
            f"{raster.file} puts the first tree at {here:.1f} m, the survey at {origin.height:.1f} "
            "m: another datum may be, feet or another place must not"
        )
    return tuple(told)
