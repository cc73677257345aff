"""How `ego` looks ahead, how far it keeps away, and what weighs how much."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orchard_cli.model.arrays import Array


@dataclass(frozen=True, slots=True)
class EgoSettings:
    """The published values, but for the two that an orchard needs: `horizon` and `inflation`."""

    horizon: float = 4.0  # m, straight line to the local target: less than the gap between rows
    inflation: float | None = None  # m around obstacles; None: the airframe's radius
    acceleration: float | None = None  # m/s² per axis; None: the mission's limit
    spacing: float = 0.4  # m between control points
    haste: float = 1.2  # knot interval in units of spacing / speed
    replan_after: float = 1.5  # m from the curve's start
    no_replan_within: float = 2.0  # m of the goal
    emergency: float = 1.0  # s to a conflict under which the vehicle stops when no way is found
    checked: float = 2 / 3  # share of each curve that is checked
    smooth: float = 1.0  # λ_s
    collide: float = 0.5  # λ_c
    feasible: float = 0.1  # λ_d
    fit: float = 1.0  # λ_f
    distance: float = 0.5  # m, s_f: kept from the surface of what the curve has touched
    tolerance: float = 0.05  # share by which a limit may be exceeded before the curve is refined
    around: float = 3.0  # m of map to the sides of the way to the local target
    above: float = 1.5  # m of map above and below it
    seed: int = 0  # of the random curves that are tried last

    @classmethod
    def published(cls) -> EgoSettings:
        """As the authors fly it: 7.5 m of horizon, obstacles one cell thicker, 1 m/s²."""
        return replace(cls(), horizon=7.5, inflation=0.099, acceleration=1.0)

    @property
    def weights(self) -> Array:
        """(4,) as the rebound takes them."""
        return np.array([self.smooth, self.collide, self.feasible, 0.0])

    @property
    def refining(self) -> Array:
        """(4,) as the refinement takes them."""
        return np.array([self.smooth, 0.0, self.feasible, self.fit])
