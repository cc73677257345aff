"""The output of a YOLO-family network as boxes, scores and classes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.arrays import Array

MOST = 200_000  # rows of an output
KEPT = 1_000  # best rows that go on to suppression


class NotYolo(ValueError):
    """An output of another shape than a YOLO network has."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """What a network proposes, in the pixels of its picture."""

    boxes: Array  # (n, 4) left, top, right, bottom
    scores: Array  # (n,)
    classes: NDArray[np.int64]  # (n,)


def candidates(output: NDArray[np.float32], classes: int, least: float) -> Candidates:
    """Rows with a score of at least `least`. The layouts, told apart by the number of classes:

    (1, 4 + c, n): centre, size, a score per class (v8, v9, v11 and v3 as exported by Ultralytics);
    (1, n, 5 + c): the same with the score that there is anything (v3, v5, v7);
    (1, n, 6): left, top, right, bottom, score, class (v10, and exports with suppression inside).
    Raises NotYolo for anything else.
    """
    if output.ndim != 3 or output.shape[0] != 1 or max(output.shape) > MOST:
        raise NotYolo(f"its output has the shape {output.shape}")
    table = output[0].astype(np.float64)
    if table.shape[0] == 4 + classes:
        boxes, chances = _from_centres(table[:4].T), table[4:].T
    elif table.shape[1] == 5 + classes:
        boxes, chances = _from_centres(table[:, :4]), table[:, 4:5] * table[:, 5:]
    elif table.shape[1] == 6:
        return _best(table[:, :4], table[:, 4], _whole(table[:, 5]), least, classes)
    else:
        raise NotYolo(f"its output {output.shape} does not fit {classes} classes")
    kind = np.argmax(np.nan_to_num(chances, nan=-1.0), axis=1)
    return _best(boxes, chances[np.arange(len(kind)), kind], kind, least, classes)


def _from_centres(rows: Array) -> Array:
    half = rows[:, 2:4] / 2
    return np.hstack([rows[:, :2] - half, rows[:, :2] + half])


def _whole(values: Array) -> NDArray[np.int64]:
    return np.where(np.abs(values) < 1e6, values, -1.0).astype(np.int64)


def _best(
    boxes: Array, scores: Array, kinds: NDArray[np.int64], least: float, classes: int
) -> Candidates:
    """Those that are finite, have an inside, and are good enough; the best KEPT of them."""
    sound = np.isfinite(boxes).all(axis=1) & np.isfinite(scores)
    with np.errstate(invalid="ignore"):
        sound &= (boxes[:, 2:] > boxes[:, :2]).all(axis=1) & (scores >= least)
    sound &= (kinds >= 0) & (kinds < classes)
    order = np.flatnonzero(sound)
    order = order[np.argsort(-scores[order], kind="stable")][:KEPT]
    return Candidates(boxes[order], np.minimum(scores[order], 1.0), kinds[order])
