"""Where along a path to be at each knot: the sampling of the guide path."""

from __future__ import annotations

import numpy as np

from orchard_cli.model.arrays import Points

from . import _kernels

_MOST = 512  # knots


def pace(
    guide: Points,
    reference: Points,
    spacing: float,
    interval: float,
    speeds: tuple[float, float],
    cruise: float,
    acceleration: float,
) -> Points:
    """Points (n + 1, 2) along a path, n whole intervals apart in time, its ends included.

    The paper samples the guide path evenly (Liu 2024, §4.3). So does this where the reference is
    flown at constant speed; where the reference slows (at a corner), or the span begins or ends
    at another speed, the points lie as far apart as the vehicle can fly.

    `guide` (m, 2 or 3) m; `reference` (k, 2 or 3): points, `spacing` s apart, of the stretch that
    the guide replaces, for its speeds; `speeds`: at the ends, m/s; `cruise`: share of the
    reference's speed to fly.
    """
    law = np.array([interval, speeds[0], speeds[1], cruise, acceleration])
    guide, reference = np.array(guide[:, :2]), np.array(reference[:, :2])  # one type of array
    out = np.empty((_MOST, 2))
    count = _kernels.pace(guide, reference, spacing, law, out)
    if count > _MOST:  # longer than any look-ahead
        out = np.empty((count, 2))
        _kernels.pace(guide, reference, spacing, law, out)
    return out[:count]
