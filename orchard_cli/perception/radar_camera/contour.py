"""A thing's outline in an image: grey, Canny, morphology (Huang 2021, §2.3, eq. 5, Fig. 4).

Needs OpenCV, of the extra `vision`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchard_cli.errors import Fault, InputError

WEIGHTS = np.array([0.299, 0.587, 0.114])  # of red, green and blue (eq. 5)


@dataclass(frozen=True, slots=True)
class Outline:
    """The pixels that a thing's contour spans. Pixel u covers u - 0.5 to u + 0.5."""

    left: float  # px
    top: float  # px
    right: float  # px
    bottom: float  # px
    cut: bool  # the image's edge cuts it

    @property
    def middle(self) -> float:
        """px, column."""
        return (self.left + self.right) / 2


@dataclass(frozen=True, slots=True)
class ContourSettings:
    """What Canny and the morphology use; the paper gives none of it."""

    blur: float = 1.0  # px, of the Gaussian before
    low: float = 25.0  # grey levels: an edge goes on where the gradient is over it
    high: float = 70.0  # and begins where it is over this
    upright: int = 9  # px: an edge that is less high is no side of a thing; the horizon is none
    close: int = 25  # px: sides so far apart are one thing's
    thin: int = 0  # px that edges stand outside of a thing, on either side
    reach: float = 12.0  # px beside a radar's reflection in which its thing must be


def grey(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(h, w) of an image (h, w, 3): the weighted sum of eq. 5."""
    weighed: NDArray[np.uint8] = np.clip(np.rint(rgb @ WEIGHTS), 0, 255).astype(np.uint8)
    return weighed


def outline(
    rgb: NDArray[np.uint8], u: float, v: float, size: tuple[float, float], s: ContourSettings
) -> Outline | None:
    """The contour of what stands at the radar's pixel (u, v); None when there is none.

    `size` px: the widest and highest that it may be; the image is looked at there only.
    """
    cv2 = opencv()
    height, width = rgb.shape[:2]
    left, right = max(int(u - size[0]), 0), min(int(u + size[0]) + 1, width)
    top, bottom = max(int(v - size[1]), 0), min(int(v + size[1]) + 1, height)
    if right - left < 3 or bottom - top < 3:
        return None
    window = np.ascontiguousarray(grey(rgb[top:bottom, left:right]))
    edges = cv2.Canny(cv2.GaussianBlur(window, (0, 0), s.blur), s.low, s.high)
    joined = cv2.morphologyEx(edges, cv2.MORPH_CLOSE, np.ones((3, 1), np.uint8))
    sides = cv2.morphologyEx(joined, cv2.MORPH_OPEN, np.ones((s.upright, 1), np.uint8))
    closed = cv2.morphologyEx(sides, cv2.MORPH_CLOSE, np.ones((5, s.close), np.uint8))
    found, _ = cv2.findContours(closed, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    boxes = np.array([cv2.boundingRect(c) for c in found]).reshape(-1, 4)
    best = _standing(boxes, u - left, s.reach)
    if best is None:
        return None
    x, y, w, h = (int(value) for value in best)
    box = (x + left + s.thin, y + top + s.thin, x + left + w - s.thin, y + top + h - s.thin)
    if box[2] <= box[0] or box[3] <= box[1]:
        return None
    cut = box[0] <= 2 or box[1] <= 2 or box[2] >= width - 2 or box[3] >= height - 2
    return Outline(box[0] - 0.5, box[1] - 0.5, box[2] - 0.5, box[3] - 0.5, cut)


def _standing(boxes: NDArray[np.int64], u: float, reach: float) -> NDArray[np.int64] | None:
    """The highest of boxes (n, 4) x, y, w, h that stand upright at column u."""
    at = (boxes[:, 0] <= u + reach) & (boxes[:, 0] + boxes[:, 2] >= u - reach)
    upright = boxes[at & (boxes[:, 3] >= 4)]
    if not len(upright):
        return None
    highest: NDArray[np.int64] = upright[int(upright[:, 3].argmax())]
    return highest


def opencv() -> Any:
    """The library. Raises InputError where it is not installed."""
    try:
        import cv2
    except ImportError:
        raise InputError(
            Fault("astar", "its camera needs OpenCV", "pip install 'orchard-cli[vision]'")
        ) from None
    return cv2
