"""Curves: the mission's geometric B-spline, and the timed trajectory that is flown."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Array, Points, Vector, frozen

DEGREE = 3


@dataclass(frozen=True, slots=True, eq=False)
class BSpline:
    """A clamped cubic B-spline in space, its parameter the path length of the fitted polyline.

    Liu 2024, eqs. 9-11. `knots` has len(control_points) + degree + 1 entries.
    """

    degree: int
    knots: Array  # (n + degree + 1,) m
    control_points_site: Points  # (n, 3) m

    def __post_init__(self) -> None:
        control = frozen(self.control_points_site, (None, 3), "control points")
        object.__setattr__(self, "control_points_site", control)
        knots = frozen(self.knots, (len(control) + self.degree + 1,), "knots")
        if (np.diff(knots) < 0).any():
            raise ValueError("knots: not increasing")
        object.__setattr__(self, "knots", knots)


@dataclass(frozen=True, slots=True, eq=False)
class MotionState:
    """Position and its first two derivatives at a time."""

    time: float  # s, flight clock
    position_site: Vector  # (3,) m
    velocity_site: Vector  # (3,) m/s
    acceleration_site: Vector  # (3,) m/s²


_BASIS = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6.0
"""Powers of the phase within a segment to the weights of its control points."""


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """A uniform cubic B-spline in time: C² in position, so speed and acceleration never step.

    Valid on [start, end], where end = start + (n - 3) interval. Segment k, which spans
    [start + k interval, start + (k + 1) interval], is governed by control points k to k + 3;
    moving control points k..m changes the curve in segments k - 3 to m only. A replan replaces
    control points and so joins with continuous position, velocity and acceleration.
    """

    start: float  # s, flight clock
    interval: float  # s between knots
    control_points_site: Points  # (n, 3) m, n >= 4

    def __post_init__(self) -> None:
        control = frozen(self.control_points_site, (None, 3), "control points")
        if len(control) < DEGREE + 1 or not self.interval > 0:
            raise ValueError("a trajectory needs four control points and a positive interval")
        object.__setattr__(self, "control_points_site", control)

    @property
    def end(self) -> float:
        """Last valid time, s."""
        return self.start + (len(self.control_points_site) - DEGREE) * self.interval

    def segment(self, time: float) -> int:
        """Index of the segment that holds `time`, clamped to the valid ones."""
        last = len(self.control_points_site) - DEGREE - 1
        return int(min(max((time - self.start) // self.interval, 0), last))

    def at(self, time: float) -> MotionState:
        """State at `time`; before the start and after the end it stands still at the end point."""
        clamped = min(max(time, self.start), self.end)
        k = self.segment(clamped)
        u = (clamped - self.start) / self.interval - k
        w, r = 1 - u, 1 / self.interval if clamped == time else 0.0
        rr = r * r
        weights = np.array(  # _BASIS and its derivatives, multiplied out
            (
                w * w * w / 6, ((3 * u - 6) * u * u + 4) / 6, ((3 * w - 6) * w * w + 4) / 6,
                u * u * u / 6,
                -w * w / 2 * r, (1.5 * u - 2) * u * r, (2 - 1.5 * w) * w * r, u * u / 2 * r,
                w * rr, (3 * u - 2) * rr, (3 * w - 2) * rr, u * rr,
            )
        ).reshape(3, 4)  # fmt: skip
        position, velocity, acceleration = weights @ self.control_points_site[k : k + 4]
        return MotionState(time, position, velocity, acceleration)

    def sample(self, times: Array) -> tuple[Points, Points, Points]:
        """Positions, velocities and accelerations at times within [start, end]: three (n, 3)."""
        phase = (np.clip(times, self.start, self.end) - self.start) / self.interval
        k = np.clip(phase.astype(int), 0, len(self.control_points_site) - DEGREE - 1)
        u = (phase - k)[:, None]
        local = np.stack([self.control_points_site[k + j] for j in range(4)], axis=1)
        w = np.einsum("ij,njd->nid", _BASIS, local)
        position = w[:, 0] + u * (w[:, 1] + u * (w[:, 2] + u * w[:, 3]))
        velocity = (w[:, 1] + u * (2 * w[:, 2] + 3 * u * w[:, 3])) / self.interval
        acceleration = (2 * w[:, 2] + 6 * u * w[:, 3]) / self.interval**2
        return position, velocity, acceleration

    def shifted(self, delay: float) -> Trajectory:
        """The same curve, `delay` seconds later."""
        return Trajectory(self.start + delay, self.interval, self.control_points_site)
