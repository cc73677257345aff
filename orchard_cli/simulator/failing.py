"""The depth camera's failures: what becomes of a good image."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .faults import CameraFault, Failure

Depth = NDArray[np.uint16]


class FailingCamera:
    """Between the drawn image and who looks at it; does nothing until something is injected."""

    def __init__(self) -> None:
        self._failure = Failure.NONE
        self._until = -math.inf
        self._good: Depth | None = None

    def inject(self, fault: CameraFault, now: float) -> None:
        """Fail in this manner from now on."""
        self._failure, self._until = fault.failure, now + fault.seconds

    def spoil(self, depth: Depth, number: int, now: float) -> Depth | None:
        """What comes out for image `number`; None: no frame at all."""
        failure = self._failure if now < self._until else Failure.NONE
        if failure is Failure.SILENT:
            return None
        if failure is Failure.BLANK:
            return np.zeros_like(depth)
        if failure is Failure.GARBAGE:
            noise = np.random.default_rng(number).integers(0, 1 << 16, depth.shape)
            return noise.astype(np.uint16)
        if failure is Failure.FROZEN and self._good is not None:
            return self._good
        self._good = depth
        return depth
