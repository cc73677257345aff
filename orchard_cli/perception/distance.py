"""How far a detected thing is: depth at P_c and P_g, by four rules (Wang 2020, §3.3)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from orchard_cli.model.obstacles import Detection

SAME = 5.0  # px between P_c and P_g, in each direction, up to which both count
LEAST = 6  # px that an object has at least
APART = 0.4  # m between object and background, at least; else all of the box is the object
LEVELS = 64  # of the histogram


class Rule(Enum):
    """Which depth was taken."""

    MEAN = "mean of P_c and P_g"
    GRAVITY = "P_g"
    CENTRE = "P_c"
    LINE = "mean of the horizontal centreline"


@dataclass(frozen=True, slots=True)
class Distance:
    """Depth of a thing's surface, m along the optical axis, and where and how it was read."""

    depth: float  # m
    rule: Rule
    column: float  # px
    row: float  # px


def distance(
    detection: Detection, depth_mm: NDArray[np.uint16], near: float, far: float
) -> Distance | None:
    """Read a detection's depth in the image (h, w) mm that it is in; None when there is none.

    Depths outside `near` to `far` m are void, as are those that the detector excludes.
    """
    near, far = max(near, detection.near), min(far, detection.far)
    rows, columns = _pixels(detection, depth_mm.shape)
    box = depth_mm[rows, columns].astype(np.float64) / 1000.0
    box[(box < near) | (box > far)] = 0.0
    middle = (detection.centre[0] - columns.start, detection.centre[1] - rows.start)
    at_centre = _read(box, middle)
    gravity = centre_of_gravity(box)
    if gravity is not None:
        at_gravity = _read(box, gravity)
        off = max(abs(gravity[0] - middle[0]), abs(gravity[1] - middle[1]))
        there = (columns.start + gravity[0], rows.start + gravity[1])
        if at_gravity > 0.0:
            if off < SAME and at_centre > 0.0:
                return Distance((at_centre + at_gravity) / 2, Rule.MEAN, *detection.centre)
            return Distance(at_gravity, Rule.GRAVITY, *there)
    if at_centre > 0.0:
        return Distance(at_centre, Rule.CENTRE, *detection.centre)
    line = box[min(int(middle[1] + 0.5), len(box) - 1)] if len(box) else np.empty(0)
    line = line[line > 0.0]
    return Distance(float(line.mean()), Rule.LINE, *detection.centre) if len(line) else None


def centre_of_gravity(box: NDArray[np.float64]) -> tuple[float, float] | None:
    """P_g: column and row of the centre of the largest near thing in a box of depths (h, w) m.

    The box is binarised at the depth that best parts near from far (Otsu's); 0 is void. None when
    it holds nothing to speak of.
    """
    valid = box > 0.0
    if int(valid.sum()) < LEAST:
        return None
    labels, count = ndimage.label(valid & (box <= _threshold(box[valid])), np.ones((3, 3)))
    if count == 0:
        return None
    sizes = np.bincount(labels.ravel())[1:]
    if sizes.max() < LEAST:
        return None
    rows, columns = np.nonzero(labels == 1 + int(sizes.argmax()))
    return float(columns.mean()), float(rows.mean())


def _threshold(depths: NDArray[np.float64]) -> float:
    """The depth that parts two classes with the greatest variance between them."""
    counts, edges = np.histogram(depths, bins=LEVELS)
    middles = (edges[1:] + edges[:-1]) / 2
    below, total = np.cumsum(counts), np.cumsum(counts * middles)
    above = below[-1] - below
    mean_near = total / np.maximum(below, 1)
    mean_far = (total[-1] - total) / np.maximum(above, 1)
    best = int(np.argmax(below * above * (mean_far - mean_near) ** 2))
    if below[best] * above[best] == 0 or mean_far[best] - mean_near[best] < APART:
        return float(edges[-1])
    return float(edges[best + 1])


def _pixels(detection: Detection, shape: tuple[int, ...]) -> tuple[slice, slice]:
    """Rows and columns of the pixels in a box, clipped to the image."""
    top, left = max(round(detection.top + 0.5), 0), max(round(detection.left + 0.5), 0)
    bottom = min(max(round(detection.bottom + 0.5), top + 1), shape[0])
    right = min(max(round(detection.right + 0.5), left + 1), shape[1])
    return slice(top, bottom), slice(left, right)


def _read(box: NDArray[np.float64], place: tuple[float, float]) -> float:
    """Depth at a pixel: the median of the valid ones in the 3 x 3 around it, 0 when void.

    It stands for the filters that smooth and fill the published depth image.
    """
    u, v = int(place[0] + 0.5), int(place[1] + 0.5)
    patch = box[max(v - 1, 0) : v + 2, max(u - 1, 0) : u + 2]
    patch = patch[patch > 0.0]
    return float(np.median(patch)) if patch.size else 0.0
