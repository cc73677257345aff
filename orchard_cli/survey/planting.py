"""The rows of a drawing: drawn as lines, told by the trees' `row`, or found from bare positions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.arrays import Array, Indices, Points

from .features import Value
from .finding import MOST_TREES, FoundRows, find_rows
from .reading import shown
from .sorting import Placed, Sorted

VERTICES_ARE_TREES = 8.0  # m: a drawn line with longer gaps is a line, not a list of trees
USUAL_GAP = 3.0  # m, between the trees on such a line
BLOCKS_APART = 25.0  # m between the nearest trees of two blocks
SCATTERED = 0.4  # m: trees that scatter more are put on their rows
_TWICE = 0.05  # m: a tree this near to the one before is the same


@dataclass(frozen=True, slots=True, eq=False)
class Planted:
    """One row of trees in the drawing's plane, in order along it."""

    where: str
    places: Points  # (n, 2) m
    heights: Array  # (n,) m of the trees; NaN: not told
    altitudes: Array  # (n,) m of the ground at them; NaN: not told


@dataclass(slots=True)
class Planting:
    """All rows, and how they came about."""

    rows: list[Planted]
    how: str
    apart: list[Planted] = field(default_factory=list)  # trees in no row, one by one
    found: FoundRows | None = None
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True, slots=True, eq=False)
class _Trees:
    where: list[str]
    places: Points
    heights: Array
    altitudes: Array

    def taken(self, index: Indices, where: str, places: Points | None = None) -> Planted:
        """Some of the trees as a row."""
        chosen = (self.places if places is None else places)[index]
        return Planted(where, chosen, self.heights[index], self.altitudes[index])


def planting(found: Sorted, file: str, gap: float | None, block: int | None,
             towards: float | None) -> Planting:  # fmt: skip
    """The rows of a sorted drawing. Raises InputError where there are none to be trusted.

    `gap` is that between the trees of bare lines, m; `towards` the rows' direction, rad from +x.
    """
    trees = _trees(found.trees)
    if found.rows:
        return _along_lines(found.rows, trees, gap)
    if not found.trees:
        raise InputError(Fault(file, "holds no trees and no rows", "draw the trees as points"))
    labels = [tree.feature.properties.get("row") for tree in found.trees]
    if any(label not in (None, "") for label in labels):
        return _by_label(trees, labels)
    return _by_finding(trees, file, block, towards)


def _trees(placed: Sequence[Placed]) -> _Trees:
    features = [tree.feature for tree in placed]
    return _Trees(
        [feature.where for feature in features],
        np.array([tree.parts[0][0] for tree in placed]).reshape(-1, 2),
        np.array([feature.number("tree_height_m", "height_m", "height") for feature in features]),
        np.array([feature.parts[0][0, 2] for feature in features]),
    )


def _by_label(trees: _Trees, labels: Sequence[Value | None]) -> Planting:
    """Rows by the trees' own word; in file order where that is in order along the row."""
    lacking = [w for w, label in zip(trees.where, labels, strict=True) if label in (None, "")]
    if lacking:
        raise InputError(
            Fault(lacking[0], "has no row, and other trees have one", "give each tree its row")
        )
    names = list(dict.fromkeys(labels))
    rows = []
    for name in names:
        index = np.array([k for k, label in enumerate(labels) if label == name])
        label = f"{name:g}" if isinstance(name, float) else shown(name)
        if len(index) < 2:
            raise InputError(
                Fault(trees.where[index[0]], f"is alone in row {label}", "a row needs two trees")
            )
        rows.append(trees.taken(index[_order(trees.places[index])], f"row {label}"))
    return Planting(rows, "told by the trees' row")


def _order(places: Points) -> Indices:
    """Indices along the line from end to end; ends are those farthest apart on the main axis."""
    centred = places - places.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    return np.argsort(centred @ axes[:, 1], kind="stable")


def _along_lines(lines: Sequence[Placed], trees: _Trees, gap: float | None) -> Planting:
    """Trees to the drawn line that each stands at; lines without trees are planted."""
    shapes = [shapely.LineString(line.parts[0]) for line in lines]
    faults = [
        Fault(line.feature.where, "is a row without length", "draw it again")
        for line, shape in zip(lines, shapes, strict=True)
        if shape.length < _TWICE
    ]
    if faults:
        raise InputError(faults)
    member, along = _nearest_lines(shapes, trees.places)
    result = Planting([], "drawn as lines")
    planted_gap = False
    for k, line in enumerate(lines):
        index = np.flatnonzero(member == k)
        if len(index) > 1:
            order = index[np.argsort(along[index], kind="stable")]
            result.rows.append(trees.taken(order, line.feature.where))
            continue
        member[index] = -1
        row, filled = _planted_line(line, gap)
        planted_gap |= filled
        result.rows.append(row)
    if planted_gap:
        result.notes.append(f"trees are taken every {gap or USUAL_GAP:g} m along bare lines")
    result.apart = [trees.taken(np.array([k]), trees.where[k]) for k in np.flatnonzero(member < 0)]
    return result


def _nearest_lines(shapes: Sequence[shapely.LineString], places: Points) -> tuple[Indices, Array]:
    """(n,) index of the line that each tree stands at, -1 for none, and (n,) m along it."""
    if not len(places):
        return np.empty(0, dtype=int), np.empty(0)
    lines, points = np.array(shapes), shapely.points(places)
    index, distance = shapely.STRtree(lines).query_nearest(
        points, return_distance=True, all_matches=False
    )
    reach = _reach(lines)
    member = np.where(distance <= reach, index[1], -1)
    return member, shapely.line_locate_point(lines[index[1]], points)


def _reach(lines: Array) -> float:
    """m from a line within which trees are its own: half the way to the next line, at most 3 m."""
    if len(lines) < 2:
        return 3.0
    _, apart = shapely.STRtree(lines).query_nearest(
        lines, return_distance=True, all_matches=False, exclusive=True
    )
    return float(np.clip(np.median(apart) / 2, 0.5, 3.0))


def _planted_line(line: Placed, gap: float | None) -> tuple[Planted, bool]:
    """The vertices as trees, with more between them where those are far apart."""
    vertices, altitudes = line.parts[0], line.feature.parts[0][:, 2]
    steps = np.hypot(*np.diff(vertices, axis=0).T)
    counts = np.ones(len(steps), dtype=int)
    if gap is not None or steps.max() > VERTICES_ARE_TREES:
        counts = np.maximum(1, np.ceil(steps / (gap or USUAL_GAP) - 1e-6).astype(int))
    if counts.sum() > MOST_TREES:
        raise InputError(Fault(line.feature.where, "is too long for a row of trees"))
    at = np.concatenate([[0.0], *(k + np.arange(1, n + 1) / n for k, n in enumerate(counts))])
    knots = np.arange(len(vertices))
    places = np.column_stack([np.interp(at, knots, axis) for axis in vertices.T])
    height = line.feature.number("tree_height_m", "height_m", "height")
    heights = np.full(len(places), height)
    row = Planted(line.feature.where, places, heights, np.interp(at, knots, altitudes))
    return row, bool((counts > 1).any())


def _by_finding(trees: _Trees, file: str, block: int | None, towards: float | None) -> Planting:
    if len(trees.places) > MOST_TREES:
        raise InputError(
            Fault(file, f"has {len(trees.places)} trees without rows, {MOST_TREES} are the most",
                  "split it, or give each tree its row")
        )  # fmt: skip
    chosen, notes = _one_block(trees.places, file, block)
    places = trees.places[chosen]
    found = find_rows(places, towards)
    if found is None:
        raise InputError(
            Fault(file, f"no rows can be found in {len(places)} trees", "draw the rows as lines")
        )
    scattered = found.scatter > SCATTERED
    stand = np.array(trees.places)
    stand[chosen] = found.on_rows if scattered else places
    if scattered:
        notes.append(
            f"the trees scatter by {found.scatter:.1f} m about their rows: each is moved onto "
            "its row's line"
        )
    rows = [trees.taken(chosen[index], f"row {k}", stand) for k, index in enumerate(found.rows, 1)]
    apart = [trees.taken(chosen[[k]], trees.where[chosen[k]]) for k in found.apart]
    return Planting(rows, "found from the trees' positions", apart, found, notes)


def _one_block(places: Points, file: str, block: int | None) -> tuple[Indices, list[str]]:
    """Indices of the chosen block's trees; blocks are counted by their number of trees."""
    blocks = _blocks(places)
    if len(blocks) > 1 and block is None:
        sizes = ", ".join(f"{len(b)} trees" for b in blocks[:9])
        raise InputError(
            Fault(file, f"{len(blocks)} blocks stand more than {BLOCKS_APART:g} m apart ({sizes})",
                  "choose one with --block 1, 2, ..., in that order")
        )  # fmt: skip
    if block is not None and not 1 <= block <= len(blocks):
        raise InputError(Fault(file, f"has {len(blocks)} blocks, no block {block}"))
    notes = [f"block {block} of {len(blocks)}"] if block is not None and len(blocks) > 1 else []
    return blocks[(block or 1) - 1], notes


def _blocks(places: Points) -> list[Indices]:
    """Indices of the trees of each block, largest first; lone trees belong to the nearest block."""
    tree = cKDTree(places)
    label = np.full(len(places), -1)
    count = 0
    for k in range(len(places)):
        if label[k] >= 0:
            continue
        edge, label[k] = [k], count
        while edge:
            near = {j for js in tree.query_ball_point(places[edge], BLOCKS_APART) for j in js}
            edge = [j for j in near if label[j] < 0]
            label[edge] = count
        count += 1
    sizes = np.bincount(label)
    large = np.flatnonzero(sizes >= max(4, 0.02 * len(places)))
    if not len(large):
        return [np.arange(len(places))]
    small = np.flatnonzero(~np.isin(label, large))
    if len(small):
        kept = np.flatnonzero(np.isin(label, large))
        label[small] = label[kept[cKDTree(places[kept]).query(places[small])[1]]]
    return sorted((np.flatnonzero(label == b) for b in large), key=len, reverse=True)


def same_trees(places: Points) -> NDArray[np.bool_]:
    """(n,) which trees stand where the one before them stands: the same tree twice."""
    steps = np.hypot(*np.diff(places, axis=0).T) if len(places) > 1 else np.empty(0)
    return np.concatenate([[False], steps < _TWICE])


def mean_direction(rows: Sequence[Planted]) -> float:
    """Direction of the rows on average, rad from +x, in [0, π)."""
    spread = np.zeros((2, 2))
    for row in rows:
        centred = row.places - row.places.mean(axis=0)
        spread += centred.T @ centred
    _, axes = np.linalg.eigh(spread)
    return math.atan2(axes[1, 1], axes[0, 1]) % math.pi
