"""Rotations between the site frame and the earth's local frames (ENU, NED).

The site frame has x at compass heading `heading` (0 is north, growing clockwise), y to the left
of x, z up.
"""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Array


def ned_from_site(heading: float) -> Array:
    """(3, 3) rotation: `v_ned = ned_from_site(heading) @ v_site`; it is its own inverse."""
    c, s = math.cos(heading), math.sin(heading)
    return np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]])


def enu_from_site(heading: float) -> Array:
    """(3, 3) rotation: `v_enu = enu_from_site(heading) @ v_site`."""
    c, s = math.cos(heading), math.sin(heading)
    return np.array([[s, -c, 0.0], [c, s, 0.0], [0.0, 0.0, 1.0]])
