"""The estimate: truth plus error, as the control loops see it."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Array, Vector

from . import _kernels


def believe(state: Array, error: Array) -> tuple[Vector, Vector, Vector]:
    """Position, velocity and attitude of a body's state (17,) with an error (9,) added."""
    position, velocity, attitude = np.empty(3), np.empty(3), np.empty(4)
    _kernels.believe(state, error, position, velocity, attitude)
    return position, velocity, attitude
