"""The autopilot's estimate of a tick. Layouts as in body/_kernels and control/_kernels, and:

noise (6, 9)  by row, for position, velocity and small turn: what is kept of the driving process,
              what is added to it, its state, the position's filtered state, what the estimate has
              jumped by, the filter's share (all of the last row)
seen (16)     0 position, 3 velocity, 6 attitude, 10 rates, 13 yaw, 14 height over the ground,
              15 greatest rate
"""

from __future__ import annotations

import numpy as np
from numba import njit

from orchard_cli.simulator.control._kernels import believe

KEEP, KICK, DRIVEN, POSITION, JUMPED, FOLLOW = range(6)


@njit(cache=True, nogil=True)
def drift(noise, normals, error):
    """The next error of the estimate, driven by `normals` (9,)."""
    for i in range(9):
        noise[DRIVEN, i] = noise[KEEP, i] * noise[DRIVEN, i] + noise[KICK, i] * normals[i]
        error[i] = noise[DRIVEN, i]
        if i < 3:
            noise[POSITION, i] += noise[FOLLOW, i] * (noise[DRIVEN, i] - noise[POSITION, i])
            error[i] = noise[POSITION, i]
        error[i] += noise[JUMPED, i]


@njit(cache=True, nogil=True)
def look(state, around, noise, normals, error, seen):
    """What the autopilot sees of a state: the error moves on, and stands in `error` (9,) after."""
    drift(noise, normals, error)
    believe(state, error, seen[0:3], seen[3:6], seen[6:10])
    w, x, y, z = seen[6], seen[7], seen[8], seen[9]
    seen[13] = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    seen[14] = max(0.0, state[2] - around[3] * state[0] - around[4] * state[1] - around[5])
    seen[15] = 0.0
    for i in range(3):
        seen[10 + i] = state[10 + i]
        seen[15] = max(seen[15], abs(state[10 + i]))
