"""Tape measurements of rows become trees in the site frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from orchard_cli.errors import Fault
from orchard_cli.model.arrays import Points
from orchard_cli.model.site import TreeRow

ROWS_APART = 0.5  # m: rows nearer than this are the same row measured twice


@dataclass(frozen=True, slots=True)
class TapedRow:
    """One row as it was measured; NaN where the file was wrong."""

    where: str  # in the file, for faults
    distance: float  # m from the row before, at this row's first tree; 0 for the first row
    far_distance: float  # m from the row before, at this row's last tree
    start: float  # m along x from the origin to the first tree
    gaps: Sequence[float]  # m between neighbours
    heights: Sequence[float]  # m, one a tree
    ground: Sequence[float]  # m above the origin's ground, one a tree
    trunks: Points | None = None  # (n, 2) m; where places were measured instead of distances


def lay_out(taped: Sequence[TapedRow]) -> list[Points]:
    """Trunks (n, 2) m of each row. NaN in, NaN out."""
    laid: list[Points] = []
    height_at, slope = 0.0, 0.0  # the row before, as the line y = height_at + slope x
    for row in taped:
        trunks = _taped_trunks(row, height_at, slope) if row.trunks is None else row.trunks
        laid.append(trunks)
        way = trunks[-1] - trunks[0]
        slope = way[1] / way[0] if way[0] > 1e-9 else np.nan
        height_at = trunks[0, 1] - slope * trunks[0, 0]
    return laid


def _taped_trunks(row: TapedRow, height_at: float, slope: float) -> Points:
    """Trunks (n, 2) m of a row beside the line y = height_at + slope x."""
    along = np.concatenate([[0.0], np.cumsum(row.gaps)])
    near = height_at + slope * row.start + row.distance
    far = height_at + slope * (row.start + along[-1]) + row.far_distance
    way = np.array([along[-1], far - near])
    way /= max(float(np.hypot(*way)), 1e-9)
    trunks: Points = np.array([row.start, near]) + along[:, None] * way
    return trunks


def crossings(taped: Sequence[TapedRow], laid: Sequence[Points]) -> list[Fault]:
    """Rows that cross or coincide."""
    whole = [k for k, trunks in enumerate(laid) if np.isfinite(trunks).all() and len(trunks) > 1]
    lines = [shapely.LineString(laid[k]) for k in whole]
    if not lines:
        return []
    pairs = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=ROWS_APART)
    faults = []
    for a, b in pairs.T:
        if a < b:
            crossing = lines[a].crosses(lines[b])
            faults.append(
                Fault(
                    taped[whole[b]].where,
                    f"the row {'crosses' if crossing else 'coincides with'} row {whole[a] + 1}",
                    "measure its distance_m again: rows lie to the left of +x, one after another",
                )
            )
    return faults


def tree_rows(taped: Sequence[TapedRow], laid: Sequence[Points]) -> tuple[TreeRow, ...]:
    """The rows as nouns. Everything must be finite."""
    return tuple(
        TreeRow(trunks, np.array(row.ground), np.array(row.heights))
        for row, trunks in zip(taped, laid, strict=True)
    )
