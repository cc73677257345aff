"""Boundary and keep-outs of a drawing: rings without holes, with not a hole lost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.ops import split

from orchard_cli.errors import Fault
from orchard_cli.model.arrays import Points

from .sorting import Placed

_MOST_HOLES = 50  # in one keep-out

Ring = tuple[str, Points]  # where it comes from; (n, 2) m corners


def fence_and_keep_outs(
    fences: Sequence[Placed], keep_outs: Sequence[Placed], faults: list[Fault]
) -> tuple[Ring | None, list[Ring]]:
    """The one boundary, and the keep-outs: those drawn, and the boundary's inner rings.

    A boundary within a boundary is an inner one. A keep-out with a hole is cut through the hole:
    flying in the hole stays allowed.
    """
    rings: list[Ring] = []
    outer = [item for item in fences if not _inside_another(item, fences)]
    rings += [(item.feature.where, item.parts[0]) for item in fences if item not in outer]
    for item in fences:
        for k, inner in enumerate(item.parts[1:], 2):
            rings.append((f"{item.feature.where}: ring {k}", inner))
    for item in keep_outs:
        if len(item.parts) - 1 > _MOST_HOLES:
            faults.append(Fault(item.feature.where, f"has more than {_MOST_HOLES} holes"))
            continue
        rings += [(item.feature.where, piece) for piece in without_holes(item.polygon)]
    return _one_fence(outer, faults), rings


def _inside_another(item: Placed, fences: Sequence[Placed]) -> bool:
    """An inner boundary, drawn as a boundary of its own."""
    polygon = shapely.Polygon(item.parts[0])
    return any(
        shapely.Polygon(other.parts[0]).contains_properly(polygon)
        for other in fences
        if other is not item
    )


def without_holes(polygon: shapely.Polygon) -> list[Points]:
    """Outlines (n, 2) of pieces that cover the polygon and nothing of its holes."""
    if not polygon.interiors:
        return [shapely.get_coordinates(polygon.exterior)[:-1]]
    _, low, _, top = polygon.bounds
    x = shapely.Polygon(polygon.interiors[0]).centroid.x
    cut = shapely.LineString([(x, low - 1), (x, top + 1)])
    return [ring for piece in split(polygon, cut).geoms for ring in without_holes(piece)]


def _one_fence(fences: Sequence[Placed], faults: list[Fault]) -> Ring | None:
    if not fences:
        return None
    if len(fences) == 1:
        return fences[0].feature.where, fences[0].parts[0]
    whole = shapely.union_all([shapely.Polygon(item.parts[0]) for item in fences])
    if not isinstance(whole, shapely.Polygon) or whole.interiors:
        faults.append(
            Fault(fences[1].feature.where, f"is one of {len(fences)} boundaries apart",
                  "a flight stays in one: draw one boundary, or split the drawing")
        )  # fmt: skip
        return None
    ring: Points = np.asarray(shapely.get_coordinates(whole.exterior)[:-1])
    return f"{len(fences)} boundaries", ring
