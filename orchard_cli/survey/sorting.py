"""What the features of a drawing stand for: trees, rows, the boundary, keep-outs, obstacles.

What a feature says of itself decides: its `kind` (or `type`) first, then its name, then its folders
from the innermost. Where nothing is said, points are trees, or obstacles when they have a radius;
lines are rows; a polygon is the boundary when all trees stand in it, a keep-out when none does.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
import shapely

from orchard_cli.errors import Fault
from orchard_cli.model.arrays import Array

from .features import Feature, Shape


class Kind(Enum):
    """What a feature stands for."""

    TREE = "tree"
    ROW = "row"
    FENCE = "fence"
    KEEP_OUT = "keep-out"
    OBSTACLE = "obstacle"
    TAKEOFF = "takeoff"
    LANDING = "landing"


_WORDS = {
    Kind.TREE: {"tree", "trees", "trunk", "trunks", "plant", "plants"},
    Kind.ROW: {"row", "rows"},
    Kind.FENCE: {"fence", "geofence", "boundary", "border", "outline", "perimeter"},
    Kind.KEEP_OUT: {
        "keepout", "keepouts", "nofly", "exclusion", "exclusions", "excluded", "hole", "building",
        "buildings", "house", "houses", "shed", "pond", "lake",
    },
    Kind.OBSTACLE: {
        "obstacle", "obstacles", "pole", "poles", "mast", "masts", "pylon", "pylons", "tower",
        "antenna", "post", "posts",
    },
    Kind.TAKEOFF: {"takeoff", "launch", "home"},
    Kind.LANDING: {"landing"},
}  # fmt: skip
_NO_ROW = {"road", "track", "path", "wire", "wires", "cable", "cables", "power", "ditch", "river"}
_SHAPES = {
    Kind.TREE: {Shape.POINT},
    Kind.ROW: {Shape.LINE},
    Kind.FENCE: {Shape.POLYGON},
    Kind.KEEP_OUT: {Shape.POLYGON},
    Kind.OBSTACLE: {Shape.POINT, Shape.POLYGON},
    Kind.TAKEOFF: {Shape.POINT},
    Kind.LANDING: {Shape.POINT},
}


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A feature with its parts in metres."""

    feature: Feature
    parts: tuple[Array, ...]  # each (n, 2) m in the drawing's plane

    @property
    def polygon(self) -> shapely.Polygon:
        """Outer and inner rings."""
        return shapely.Polygon(self.parts[0], self.parts[1:])


@dataclass(slots=True)
class Sorted:
    """The features of a drawing by what they stand for."""

    trees: list[Placed] = field(default_factory=list)
    rows: list[Placed] = field(default_factory=list)
    fences: list[Placed] = field(default_factory=list)
    keep_outs: list[Placed] = field(default_factory=list)
    obstacles: list[Placed] = field(default_factory=list)
    takeoffs: list[Placed] = field(default_factory=list)
    landings: list[Placed] = field(default_factory=list)


def sort(placed: Sequence[Placed], faults: list[Fault]) -> Sorted:
    """Every feature in one list, or a fault for it."""
    found = Sorted()
    unsaid = []
    for drawn in placed:
        feature = drawn.feature
        item = _closed_as_polygon(drawn, faults)
        if item.feature.shape is Shape.POLYGON and not _is_simple(item, faults):
            continue
        kind = _said(item.feature)
        if kind is not None and item.feature.shape not in _SHAPES[kind]:
            faults.append(
                Fault(feature.where, f"is a {feature.shape.value} and called a {kind.value}",
                      f"draw it as a {min(s.value for s in _SHAPES[kind])}, or rename it")
            )  # fmt: skip
        elif kind is None and item.feature.shape is Shape.POLYGON:
            unsaid.append(item)
        else:
            _list_of(found, kind or _usual(item.feature), item.feature.shape).append(item)
    _sort_polygons(unsaid, found, faults)
    return found


def _list_of(found: Sorted, kind: Kind, shape: Shape) -> list[Placed]:
    if kind is Kind.OBSTACLE and shape is Shape.POLYGON:
        return found.keep_outs
    return {
        Kind.TREE: found.trees, Kind.ROW: found.rows, Kind.FENCE: found.fences,
        Kind.KEEP_OUT: found.keep_outs, Kind.OBSTACLE: found.obstacles,
        Kind.TAKEOFF: found.takeoffs, Kind.LANDING: found.landings,
    }[kind]  # fmt: skip


def _sayings(feature: Feature) -> Iterator[str]:
    for key in ("kind", "type"):
        if isinstance(value := feature.properties.get(key), str):
            yield value
    yield feature.name
    yield from reversed(feature.layers)


def _words(saying: str) -> set[str]:
    """Small words of a name; keep-out, keep_out, no fly and take-off as one word each."""
    text = re.sub(r"[^a-z]+", " ", saying.lower())
    text = re.sub(r"\b(keep|no|take) (outs?|fly|off)\b", r"\1\2", text)
    return set(text.split())


def _said(feature: Feature) -> Kind | None:
    """What a feature says that it is: the first saying that names just one kind."""
    for saying in _sayings(feature):
        words = _words(saying)
        kinds = [kind for kind, names in _WORDS.items() if words & names]
        if len(kinds) == 1:
            return kinds[0]
    return None


def _usual(feature: Feature) -> Kind:
    if feature.shape is Shape.LINE:
        return Kind.ROW
    has_radius = np.isfinite(feature.number("radius_m", "radius"))
    return Kind.OBSTACLE if has_radius else Kind.TREE


def _closed_as_polygon(item: Placed, faults: list[Fault]) -> Placed:
    """A closed line is the outline of what it says that it is."""
    feature, line = item.feature, item.parts[0]
    if feature.shape is not Shape.LINE:
        return item
    if _said(feature) is None and (names := _NO_ROW & _words(feature.name)):
        faults.append(
            Fault(feature.where, f"is a line called {min(names)}, not a row",
                  "draw a keep-out polygon round it, or remove it")
        )  # fmt: skip
    if len(line) < 4 or np.abs(line[0] - line[-1]).max() > 1e-6:
        return item
    rings = (feature.parts[0][:-1],)
    closed = Feature(
        feature.where, Shape.POLYGON, rings, feature.name, feature.layers, feature.properties
    )
    return Placed(closed, (line[:-1],))


def _is_simple(item: Placed, faults: list[Fault]) -> bool:
    polygon = item.polygon
    if polygon.is_valid and polygon.area > 1e-6:
        return True
    what = "has no area" if polygon.area <= 1e-6 else "has an outline that crosses itself"
    why = shapely.is_valid_reason(polygon).partition("[")[0].lower()
    what = what if polygon.area <= 1e-6 else f"{what} ({why})"
    faults.append(Fault(item.feature.where, what, "order its corners"))
    return False


def _sort_polygons(unsaid: Sequence[Placed], found: Sorted, faults: list[Fault]) -> None:
    """Polygons that say nothing, by whether the trees stand in them."""
    lines = [tree.parts[0] for tree in (*found.trees, *found.rows)]
    trees = shapely.MultiPoint(np.concatenate(lines) if lines else np.empty((0, 2)))
    for item in unsaid:
        outer = shapely.Polygon(item.parts[0])
        if not trees.is_empty and outer.buffer(1e-6).covers(trees):
            found.fences.append(item)
        elif not outer.intersects(trees):
            found.keep_outs.append(item)
        else:
            faults.append(
                Fault(item.feature.where, "is a polygon with some of the trees in it",
                      "name it boundary or keep-out")
            )  # fmt: skip
