"""Walking along a trajectory through the map: is it free, and within its limits?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.mapping import DistanceField
from orchard_cli.model.trajectory import DEGREE, Trajectory

from . import _kernels

TICK = 0.0625  # s between samples: every 6 cm at 1 m/s
SLACK = 0.02  # m: how much nearer than it was a walk that begins too near may come


@dataclass(frozen=True, slots=True)
class Inspection:
    """What a walk along a trajectory met."""

    blocked_at: float | None  # m of path to the first place that is too near; None: free
    blocked_time: float  # s, when that is; inf when free
    clearance: float  # m, least distance in the field
    speed: float  # m/s, greatest
    acceleration: float  # m/s², greatest
    turning: float  # rad/s, greatest rate of the tangent where faster than 0.5 m/s
    length: float  # m walked


def inspect(
    trajectory: Trajectory, field: DistanceField, begin: float, end: float, floor: float
) -> Inspection:
    """Walk from time `begin` to `end` (clipped to the trajectory) by the rule `floor`.

    A place is too near when the field there is under `floor`, m. A walk that begins too near may
    leave but not come nearer (by more than 2 cm).
    """
    control = trajectory.control_points_site
    last = float(len(control) - DEGREE)
    first_phase = min(max((begin - trajectory.start) / trajectory.interval, 0.0), last)
    last_phase = min(max((end - trajectory.start) / trajectory.interval, 0.0), last)
    found = np.empty(7)
    _kernels.inspect(
        control, trajectory.interval, first_phase, last_phase,
        max(2, round(trajectory.interval / TICK)),
        field.values, frame_of(field), floor, SLACK, found,
    )  # fmt: skip
    free = not np.isfinite(found[0])
    return Inspection(
        None if free else float(found[0]),
        np.inf if free else trajectory.start + float(found[1]) * trajectory.interval,
        *(float(x) for x in found[2:]),
    )


def frame_of(field: DistanceField) -> np.ndarray:
    """Where a field lies, as the kernels take it: x0, y0, cell, value outside."""
    return np.array([field.origin_site[0], field.origin_site[1], field.cell, field.reach])
