"""From points to a trajectory that joins the active one and ends in the mission's own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.mission import Limits
from orchard_cli.model.trajectory import DEGREE, Trajectory

from .bends import BendLaw, through_bends
from .fit import rounded
from .pacing import pace
from .rejoin import path_lengths
from .splice import Head, knots_of, splice
from .timing import peaks

WIDE = 3.0  # m of cut: corners are rounded as much as their legs allow
SHORT = 0.05  # m: nearer points are one
PACING = 0.6  # share of the acceleration limit, between speeds
TOLERANCE = 1.03  # times a limit


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """A trajectory back to the reference, and when it is there."""

    trajectory: Trajectory
    rejoin: float  # s
    guide_site: Points  # (n, 3) m


def course(
    head: Head,
    corners_site: Points,
    reference: Trajectory,
    first: int,
    rejoin: int,
    cruise: float,
    limits: Limits,
    cut: float | Array = WIDE,
    slow_in_bends: bool = False,
) -> Course | str:
    """Fly the head, then a path with rounded corners (n, 3) m, then the reference from its knot
    `rejoin` on; or the reason why that is beyond the limits.

    `first`: the reference's knot beside the head's last; `cruise`: share of its speed; `cut` m, or
    (n,) m: how near the corners are passed. The path begins at the head's last control point and
    ends at the reference's `rejoin`; it is flown at the cruise speed, or with `slow_in_bends` as
    slowly as each bend needs.
    """
    tail = reference.control_points_site[rejoin:]
    if len(tail) < DEGREE:
        return "the route ends before it can be joined again"
    guide = smooth(np.vstack([head.control_points_site[-1], *corners_site, tail[0]]), cut)
    if slow_in_bends:
        law = BendLaw.of(limits, cruise * limits.speed)
        flat = through_bends(guide, head.interval, _speeds(head, tail), law)
    else:
        flat = _paced(head, guide, reference, first, rejoin, cruise, limits)
    free = _raised(flat, guide)
    if abs(head.interval - reference.interval) > 1e-9:
        return "what is flown now is no part of the route"
    trajectory = splice(head, free, reference, rejoin)
    kept = len(head.control_points_site)
    over = _beyond(trajectory, kept - DEGREE, kept + len(free) + DEGREE, limits)
    if over:
        return over
    back = trajectory.start + (kept + len(free)) * trajectory.interval
    return Course(trajectory, back, guide)


def rejoin_at(reference: Trajectory, first: int, place: Vector, lead: float) -> int:
    """The reference's control point `lead` m behind where it passes a place (2,) or (3,), counted
    from `first` on. Never the last three, which bring it to rest."""
    knots = knots_of(reference.control_points_site[first : first + 120])
    lengths = path_lengths(knots)
    beside = int(np.argmin(np.hypot(*(knots[:, :2] - place[:2]).T)))
    behind = int(np.searchsorted(lengths, lengths[beside] + lead))
    return min(first + max(behind, 1) + 1, len(reference.control_points_site) - DEGREE)


def smooth(corners_site: Points, cut: float | Array = WIDE) -> Points:
    """A path (m, 3) m along corners (n, 3) m, each rounded as much as its legs and `cut` allow."""
    apart = np.linalg.norm(np.diff(corners_site, axis=0), axis=1)
    far = np.concatenate([[True], apart > SHORT])
    kept: Points = corners_site[far]
    if len(kept) < 3:
        return kept if len(kept) == 2 else np.asarray(corners_site[[0, -1]])
    try:
        points: Points = rounded(kept, np.broadcast_to(cut, len(far) - 2)[far[1:-1]]).points_site
    except ValueError:  # a turn straight back: no smooth path has it
        return kept
    return points


def _paced(
    head: Head,
    guide: Points,
    reference: Trajectory,
    first: int,
    rejoin: int,
    cruise: float,
    limits: Limits,
) -> Points:
    """Places (n, 2) m along the guide, its ends included, one per interval."""
    tail = reference.control_points_site[rejoin:]
    begin = min(first + DEGREE - 1, rejoin - 1)
    replaced = reference.control_points_site[begin : rejoin + 1]
    speeds = _speeds(head, tail)
    return pace(
        guide, replaced, reference.interval, head.interval, speeds, cruise,
        PACING * limits.acceleration,
    )  # fmt: skip


def _speeds(head: Head, tail: Points) -> tuple[float, float]:
    """m/s at the end of the head, and at the beginning of the reference's tail."""
    control = head.control_points_site
    return (
        float(np.linalg.norm(control[-1, :2] - control[-2, :2])) / head.interval,
        float(np.linalg.norm(tail[1, :2] - tail[0, :2])) / head.interval,
    )


def _raised(flat: Points, guide: Points) -> Points:
    """Control points (n - 2, 3) at places (n, 2) with the guide's heights, without the ends."""
    heights = np.interp(_along(flat, guide), path_lengths(guide), guide[:, 2])
    free: Points = np.column_stack([flat, heights])[1:-1]
    return free


def _along(flat: Points, guide: Points) -> Array:
    """m of level path along the guide to each of the points (n, 2), which lie on it in order."""
    total = path_lengths(guide)[-1]
    lengths = path_lengths(np.column_stack([flat, np.zeros(len(flat))]))
    scaled: Array = lengths * (total / max(float(lengths[-1]), 1e-9))
    return scaled


def _beyond(trajectory: Trajectory, begin: int, end: int, limits: Limits) -> str:
    """What of a stretch of control points is over a limit; empty when nothing is."""
    points = trajectory.control_points_site[max(begin, 0) : end]
    done = peaks(Trajectory(0.0, trajectory.interval, points))
    for what, is_, may, unit in (
        ("speed", done.speed, limits.speed, "m/s"),
        ("acceleration", done.acceleration, limits.acceleration, "m/s²"),
        ("turning", done.yaw_rate, limits.yaw_rate, "rad/s"),
        ("climbing", done.climb_speed, limits.climb_speed, "m/s"),
    ):
        if is_ > may * TOLERANCE:
            return f"{what} {is_:.2f} over {may:.2f} {unit}"
    return ""
