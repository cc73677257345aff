"""Whether a depth image can be believed: not blank, not noise, not the same one again and again."""

from __future__ import annotations

import math
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from orchard_cli.mapping.band import as_input
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.vehicle import VehicleState
from orchard_cli.motion.yaw import wrapped

from . import _kernels

Depth = NDArray[np.uint16]

ROWS = 8  # every so many rows are looked at
LEAP = 0.25  # of the nearer depth, between neighbours in a row: an edge, or noise
EDGES = 0.5  # share of neighbours that no scene has as edges: foliage has less than a fifth
ENOUGH = 200  # pairs of neighbours with returns, to judge by
ALIKE = 0.99  # share of returns of one and the same depth that no scene gives
MOVED = 0.2  # m, or
TURNED = 0.06  # rad, after which a camera must see something else
LASTING = 0.3  # s of bad frames before they count


class Sight(Enum):
    """What an image is worth."""

    GOOD = "good"
    BLANK = "blank"
    GARBLED = "garbled"
    FROZEN = "frozen"


def worth(depth_mm: Depth) -> Sight:
    """Judge one image (height, width) by itself."""
    if not depth_mm.any():
        return Sight.BLANK
    pairs, leaps, alike = _kernels.texture(as_input(depth_mm, np.uint16), ROWS, np.float32(LEAP))
    if pairs < ENOUGH:
        return Sight.GOOD
    looked_at = -(-depth_mm.shape[0] // ROWS) * depth_mm.shape[1]
    noise = leaps > EDGES * pairs or alike > ALIKE * looked_at
    return Sight.GARBLED if noise else Sight.GOOD


class Eyesight:
    """Judges every image, and remembers where the vehicle was when the newest one was new."""

    def __init__(self) -> None:
        self._depth: Depth | None = None
        self._there: VehicleState | None = None
        self._ill = Sight.GOOD
        self._since = -math.inf  # s, of the frames' stamps, when it became so
        self._newest = -math.inf

    def look(self, frame: DepthFrame, state: VehicleState | None) -> Sight:
        """What a frame is worth that came while the vehicle was there."""
        sight = worth(frame.depth_mm)
        if sight is Sight.GOOD:
            sight = self._frozen(frame, state)
        if sight is not self._ill:
            self._ill, self._since = sight, frame.time
        self._newest = frame.time
        return sight

    @property
    def ill(self) -> Sight:
        """What has been wrong with the frames for LASTING s up to the newest; else GOOD."""
        return self._ill if self._newest - self._since >= LASTING else Sight.GOOD

    def _frozen(self, frame: DepthFrame, state: VehicleState | None) -> Sight:
        again = self._depth is not None and _alike(self._depth, frame.depth_mm)
        if not again or state is None or self._there is None:
            self._depth, self._there = frame.depth_mm, state
            return Sight.GOOD
        moved = float(np.linalg.norm(state.position_site - self._there.position_site))
        turned = abs(wrapped(state.yaw_site - self._there.yaw_site))
        return Sight.FROZEN if moved > MOVED or turned > TURNED else Sight.GOOD


def _alike(a: Depth, b: Depth) -> bool:
    """Whether two images are the same in every pixel; most differ in the first rows looked at."""
    return np.array_equal(a[::ROWS], b[::ROWS]) and np.array_equal(a, b)
