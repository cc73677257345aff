"""The wind, by how far the vehicle leans to stand against it."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.model.tank import GRAVITY
from orchard_cli.model.vehicle import VehicleState

SMOOTHING = 3.0  # s: a gust that is over sooner is flown through


def push(state: VehicleState, wanted_site: Vector) -> Vector:
    """(2,) m/s²: what the rotors push against, over the acceleration (3,) that was asked for."""
    w, x, y, z = state.site_from_body.tolist()
    lean = np.array([2 * (x * z + w * y), 2 * (y * z - w * x)])  # of the body's z
    push_site: Vector = GRAVITY / max(1 - 2 * (x * x + y * y), 0.1) * lean - wanted_site[:2]
    return push_site


class Lean:
    """The lean that is left when what was asked for and the gusts are taken out of it."""

    def __init__(self) -> None:
        self._push = np.zeros(2)
        self._time = -math.inf

    def after(self, state: VehicleState, wanted_site: Vector) -> None:
        """One more look at the vehicle, which was asked for an acceleration (3,) m/s²."""
        dt = state.time - self._time
        if not dt > 0:
            return
        self._time = state.time
        if dt > SMOOTHING:  # the first look, or after a silence
            self._push = np.zeros(2)
            return
        share = 1.0 - math.exp(-dt / SMOOTHING)
        self._push = self._push + share * (push(state, wanted_site) - self._push)

    @property
    def angle(self) -> float:
        """rad off the upright."""
        return math.atan(float(np.linalg.norm(self._push)) / GRAVITY)
