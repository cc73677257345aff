"""Where a forward-looking camera sits on the airframe."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from orchard_cli.model.arrays import Array, Vector, frozen
from orchard_cli.model.depth import FORWARD


@dataclass(frozen=True, slots=True, eq=False)
class Mount:
    """Optical centre in the body frame (forward, left, up) and the camera's tilt."""

    position_body: Vector = field(default_factory=lambda: np.array([0.1, 0.0, 0.0]))  # (3,) m
    pitch_down: float = 0.0  # rad, of the optical axis below the nose

    def __post_init__(self) -> None:
        object.__setattr__(self, "position_body", frozen(self.position_body, (3,), "position"))
        if not abs(self.pitch_down) < math.pi / 2:
            raise ValueError("pitch_down: a camera that looks ahead is tilted by less than 90°")

    @property
    def body_from_camera(self) -> Array:
        """(3, 3): turned about the body's y axis (left), nose down for a positive pitch."""
        c, s = math.cos(self.pitch_down), math.sin(self.pitch_down)
        turned: Array = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]) @ FORWARD
        return turned
