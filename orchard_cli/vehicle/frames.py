"""Between the autopilot's local NED / body FRD and the site frame / body FLU."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.geometry.frames import ned_from_site
from orchard_cli.geometry.rotations import multiply
from orchard_cli.model.arrays import Array, Vector

_FRD_FROM_FLU = np.array([0.0, 1.0, 0.0, 0.0])  # half a turn about the nose


@dataclass(frozen=True, slots=True, eq=False)
class LocalFrame:
    """Where the autopilot's local NED frame lies in the site frame.

    `ned_from_site` is a half turn about a horizontal axis, hence its own inverse.
    """

    heading: float  # rad, compass heading of the site's +x
    origin_site: Vector  # (3,) m: the local frame's origin, moved to the ground in height

    @property
    def _rotation(self) -> Array:
        return ned_from_site(self.heading)

    @property
    def _quaternion(self) -> Vector:
        return np.array([0.0, np.cos(self.heading / 2), np.sin(self.heading / 2), 0.0])

    def position_site(self, position_ned: Vector) -> Vector:
        """(3,) m in local NED → (3,) m in the site frame."""
        return self._rotation @ position_ned + self.origin_site

    def position_ned(self, position_site: Vector) -> Vector:
        """(3,) m in the site frame → (3,) m in local NED."""
        return self._rotation @ (position_site - self.origin_site)

    def vector_site(self, vector_ned: Vector) -> Vector:
        """Turn a (3,) velocity or acceleration from NED into the site frame."""
        return self._rotation @ vector_ned

    def vector_ned(self, vector_site: Vector) -> Vector:
        """Turn a (3,) velocity or acceleration from the site frame into NED."""
        return self._rotation @ vector_site

    def site_from_body(self, ned_from_frd: Vector) -> Vector:
        """Attitude quaternion (w, x, y, z): NED from FRD → site from FLU."""
        return multiply(multiply(self._quaternion, ned_from_frd), _FRD_FROM_FLU)

    def yaw_ned(self, yaw_site: float) -> float:
        """Yaw in rad, counter-clockwise from +x → clockwise from north, in (-π, π]."""
        yaw = self.heading - yaw_site
        return float(np.arctan2(np.sin(yaw), np.cos(yaw)))


def flu_from_frd(rates_frd: Vector) -> Vector:
    """Angular velocity (3,) rad/s from body FRD to body FLU."""
    turned: Vector = rates_frd * np.array([1.0, -1.0, -1.0])
    return turned
