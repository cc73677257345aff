"""The body's pose at a frame's time stamp, from the poses measured around it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

import numpy as np

from orchard_cli.model.vehicle import Pose

from .rotations import slerp

EDGE = 0.02
"""s: a time this little outside the measured span takes the span's first or last pose."""


def interpolate(poses: Sequence[Pose], time: float) -> Pose | None:
    """Pose at `time`: position linear, attitude along the great arc, between the two around it.

    `poses` are in order of time. None when `time` is more than EDGE outside their span: a frame
    without its pose is dropped, for a guessed pose would paint obstacles where there are none.
    """
    if not poses or not poses[0].time - EDGE <= time <= poses[-1].time + EDGE:
        return None
    after = bisect_right(poses, time, key=lambda pose: pose.time)
    if after in (0, len(poses)):
        edge = poses[0] if after == 0 else poses[-1]
        return Pose(time, np.array(edge.position_site), np.array(edge.site_from_body))
    old, new = poses[after - 1], poses[after]
    share = (time - old.time) / (new.time - old.time)
    position = (1 - share) * np.asarray(old.position_site) + share * np.asarray(new.position_site)
    return Pose(time, position, slerp(old.site_from_body, new.site_from_body, share))
