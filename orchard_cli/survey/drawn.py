"""A drawing becomes the tables of a survey, as survey TOML would say them.

Everything that is drawn is in them, or in a fault, or in a note: trees in no row become obstacles,
as the vehicle must not fly into them either.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.geometry.geodesy import site_from_wgs84
from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.site import HeightReference, SiteOrigin

from .areas import fence_and_keep_outs
from .features import Drawing
from .finding import FoundRows
from .given import Given
from .planting import Planted, Planting, planting, same_trees
from .site_frame import Site, Tables, towards_of
from .sorting import Placed, Sorted, sort

FARTHEST = 5_000.0  # m from the first feature
OVER_CANOPY = 1.5  # m, flight height where none is given
TREE_RADIUS = 1.0  # m of a tree in no row, as an obstacle


@dataclass(frozen=True, slots=True, eq=False)
class Recognised:
    """How a drawing was understood."""

    how: str  # where its rows come from
    found: FoundRows | None  # when they were found from bare positions
    notes: tuple[str, ...]
    wheres: tuple[str, ...]  # of each row


def tables_of(drawing: Drawing, given: Given) -> tuple[Tables, Recognised]:
    """Survey tables from features. Raises InputError with every fault that can be told at once."""
    faults: list[Fault] = []
    placed, plane = _on_a_plane(drawing, given)
    found = sort(placed, faults)
    fence, keep_outs = fence_and_keep_outs(found.fences, found.keep_outs, faults)
    if faults:
        raise InputError(faults)
    rows = planting(found, drawing.file, given.tree_gap_m, given.block, towards_of(given))
    _drop_twins(rows)
    _fill_heights(rows, drawing.file, given, faults)
    site = Site(rows, plane, drawing, given, faults)
    obstacles = _obstacles(found, rows, site, faults)
    if faults:
        raise InputError(faults)
    tables: Tables = {
        **{k: v for k, v in given.settings.items() if k not in ("site", "flight")},
        "site": site.table(),
        "flight": _flight(found, site, given, rows, faults),
        "row": [site.row(row) for row in rows.rows],
    }
    tables["obstacle"] = [*tables.get("obstacle", []), *obstacles]
    if fence is not None:
        tables["fence"] = {"points_m": site.ring(fence[1])}
    tables["keep_out"] = [
        *tables.get("keep_out", []), *({"points_m": site.ring(ring)} for _, ring in keep_outs)
    ]  # fmt: skip
    tables = {key: value for key, value in tables.items() if value != []}
    if faults:
        raise InputError(faults)
    notes = (*rows.notes, *_notes(found, rows, fence is not None, len(keep_outs), drawing))
    return tables, Recognised(rows.how, rows.found, notes, tuple(r.where for r in rows.rows))


def _on_a_plane(drawing: Drawing, given: Given) -> tuple[list[Placed], SiteOrigin]:
    """The features in metres east and north of the first one."""
    if not drawing.features:
        raise InputError(Fault(drawing.file, "holds nothing", "draw the trees as points"))
    first = drawing.features[0].parts[0][0]
    plane = SiteOrigin(
        float(first[0]),
        float(first[1]),
        given.ground_height_m or 0.0,
        HeightReference.AMSL,
        math.pi / 2,
    )
    parts = [part for feature in drawing.features for part in feature.parts]
    whole = np.concatenate(parts)
    heights = np.where(np.isfinite(whole[:, 2]), whole[:, 2], plane.height)
    flat = site_from_wgs84(plane, np.column_stack([whole[:, :2], heights]))[:, :2]
    far = np.hypot(*flat.T) > FARTHEST
    if far.any():
        ends = np.cumsum([len(part) for part in parts])
        owners = [feature for feature in drawing.features for _ in feature.parts]
        feature = owners[int(np.searchsorted(ends, far.argmax(), side="right"))]
        raise InputError(
            Fault(feature.where, f"lies more than {FARTHEST / 1000:g} km from the first feature",
                  "split the drawing, or mend its coordinates")
        )  # fmt: skip
    pieces = iter(np.split(flat, np.cumsum([len(part) for part in parts])[:-1]))
    return [Placed(f, tuple(next(pieces) for _ in f.parts)) for f in drawing.features], plane


def _drop_twins(rows: Planting) -> None:
    for k, row in enumerate(rows.rows):
        same = same_trees(row.places)
        if same.any():
            kept = ~same
            rows.rows[k] = Planted(
                row.where, row.places[kept], row.heights[kept], row.altitudes[kept]
            )
            rows.notes.append(f"{row.where}: {same.sum()} trees stand twice and are taken once")


def _fill_heights(rows: Planting, file: str, given: Given, faults: list[Fault]) -> None:
    usual = given.tree_height_m
    lacking = 0
    for group in (rows.rows, rows.apart):
        for k, row in enumerate(group):
            missing = np.isnan(row.heights)
            lacking += int(missing.sum()) if usual is None else 0
            heights = np.where(missing, math.nan if usual is None else usual, row.heights)
            group[k] = Planted(row.where, row.places, heights, row.altitudes)
    if lacking:
        faults.append(
            Fault(file, f"{lacking} trees have no height",
                  "give the highest with --tree-height, or each its property height_m")
        )  # fmt: skip


def _obstacles(found: Sorted, rows: Planting, site: Site, faults: list[Fault]) -> list[Tables]:
    listed = []
    for item in found.obstacles:
        feature = item.feature
        radius, height = (feature.number(f"{k}_m", k) for k in ("radius", "height"))
        for name, value in (("radius_m", radius), ("height_m", height)):
            if math.isnan(value):
                faults.append(
                    Fault(feature.where, f"is an obstacle without {name}", "give it as a property")
                )
        size = (radius, height)
        listed.append(
            _obstacle(site, feature.name or "pole", item.parts[0], size, feature.parts[0][:, 2])
        )
    for row in rows.apart:
        size = (TREE_RADIUS, float(row.heights[0]))
        listed.append(_obstacle(site, "tree in no row", row.places, size, row.altitudes))
    return listed


def _obstacle(
    site: Site, name: str, places: Points, size: tuple[float, float], altitudes: Array
) -> Tables:
    x, y = site.places(places)[0].tolist()
    table = {"name": name[:200], "x_m": x, "y_m": y, "radius_m": size[0], "height_m": size[1]}
    ground = float(site.ground(altitudes)[0])
    return table | ({"ground_m": ground} if math.isfinite(ground) and ground else {})


def _flight(found: Sorted, site: Site, given: Given, rows: Planting, faults: list[Fault]) -> Tables:
    """[flight]: as given, else at a height over the canopies."""
    table = dict(given.settings.get("flight", {}))
    if given.flight_height_m is not None:
        table |= {"height_m": given.flight_height_m, "height_above": "ground"}
    if "height_m" not in table:
        table |= {"height_m": OVER_CANOPY, "height_above": "canopy"}
        rows.notes.append(f"flight height not given: {OVER_CANOPY:g} m above the canopies")
    for key, items in (("takeoff_m", found.takeoffs), ("landing_m", found.landings)):
        if len(items) > 1:
            faults.append(Fault(items[1].feature.where, f"is a second {key[:-2]}", "keep one"))
        if items and key not in table:
            table[key] = site.places(items[0].parts[0])[0].tolist()
    return table


def _notes(
    found: Sorted, rows: Planting, fence: bool, keep_outs: int, drawing: Drawing
) -> list[str]:
    notes = []
    if rows.apart:
        notes.append(f"{len(rows.apart)} trees in no row are kept as obstacles: " + ", ".join(
            tree.where.removeprefix(f"{drawing.file}: ") for tree in rows.apart[:5]
        ) + (", ..." if len(rows.apart) > 5 else ""))  # fmt: skip
    if found.obstacles:
        notes.append(f"{len(found.obstacles)} obstacles")
    if fence:
        notes.append("a boundary")
    if keep_outs:
        notes.append(f"{keep_outs} keep-outs")
    return notes
