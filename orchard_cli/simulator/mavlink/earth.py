"""Between the site frame and what MAVLink speaks: local NED, body FRD, and degrees.

The local frame's origin is where the autopilot booted, as PX4's is; near it the earth is taken as
flat (300 m away that is off by less than a centimetre).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.geometry.frames import ned_from_site
from orchard_cli.geometry.geodesy import wgs84_from_site
from orchard_cli.model.arrays import Vector
from orchard_cli.model.site import SiteOrigin
from orchard_cli.simulator.autopilot.seen import Seen

Triple = tuple[float, float, float]
PROBE = 100.0  # m, for the degrees per metre around the origin


class Earth:
    """The local frame of one flight."""

    def __init__(self, origin: SiteOrigin, start_site: Vector) -> None:
        turn = ned_from_site(origin.heading)  # its own inverse
        self._c, self._s = float(turn[0, 0]), float(turn[1, 0])
        self._heading = origin.heading
        self._origin, self._turn = origin, turn
        half = origin.heading / 2
        self._half = (math.cos(half), math.sin(half))
        self._settle(np.array(start_site))

    def move(self, moved_site: Vector) -> None:
        """Put the local origin elsewhere, by (3,) m: every local coordinate jumps."""
        self._settle(self._start + moved_site)

    def _settle(self, start_site: Vector) -> None:
        self._start = start_site
        probes_ned = np.array([[0.0, 0.0, 0.0], [PROBE, 0.0, 0.0], [0.0, PROBE, 0.0]])
        probes_wgs84 = wgs84_from_site(self._origin, probes_ned @ self._turn + start_site)
        here, north, east = probes_wgs84
        self.latitude, self.longitude, self.height = (float(value) for value in here)
        self._per_north = float(north[0] - here[0]) / PROBE
        self._per_east = float(east[1] - here[1]) / PROBE

    def local(self, position_site: Vector) -> Triple:
        """Metres north, east, down of the local origin; NaN stays in its own axes."""
        return self.turned(position_site - self._start)

    def turned(self, vector_site: Vector) -> Triple:
        """A velocity or acceleration in NED; a NaN height does not spoil the horizontal."""
        x, y, z = vector_site.tolist()
        c, s = self._c, self._s
        return c * x + s * y, s * x - c * y, -z

    def site(self, north: float, east: float, down: float) -> Vector:
        """(3,) m in the site frame of a local position; NaN stays in its own axes."""
        return np.asarray(self.vector_site(north, east, down) + self._start)

    def vector_site(self, north: float, east: float, down: float) -> Vector:
        """(3,) in the site frame of a NED vector; a NaN height does not spoil the horizontal."""
        c, s = self._c, self._s
        return np.array([c * north + s * east, s * north - c * east, -down])

    def yaw_site(self, yaw_ned: float) -> float:
        """Clockwise from north → counter-clockwise from the site's +x, radians. Its own inverse."""
        return math.remainder(self._heading - yaw_ned, math.tau)

    def degrees(self, north: float, east: float) -> tuple[float, float]:
        """Latitude and longitude of a local position."""
        return self.latitude + north * self._per_north, self.longitude + east * self._per_east

    def metres(self, latitude: float, longitude: float) -> tuple[float, float]:
        """North and east of a latitude and longitude."""
        return (
            (latitude - self.latitude) / self._per_north,
            (longitude - self.longitude) / self._per_east,
        )

    def attitude(self, site_from_body: Vector) -> tuple[float, float, float, float]:
        """ned_from_frd of a site_from_flu quaternion.

        ned_from_site is half a turn about (cos h/2, sin h/2, 0), flu_from_frd half a turn about x.
        """
        w, x, y, z = site_from_body.tolist()
        c, s = self._half
        # (0, c, s, 0) * (w, x, y, z)
        w, x, y, z = -c * x - s * y, c * w + s * z, s * w - c * z, c * y - s * x
        # (w, x, y, z) * (0, 1, 0, 0)
        w, x, y, z = -x, w, z, -y
        return (w, x, y, z) if w >= 0 else (-w, -x, -y, -z)


@dataclass(frozen=True, slots=True)
class Told:
    """The estimate of a tick as MAVLink tells it."""

    boot_ms: int
    boot_us: int
    ned: Triple  # m
    velocity: Triple  # m/s, NED
    q: tuple[float, float, float, float]  # ned_from_frd
    rates: Triple  # rad/s, FRD
    latitude: float  # deg
    longitude: float  # deg
    altitude: float  # m
    above_home: float  # m
    height: float  # m above the ground

    @property
    def roll_pitch_yaw(self) -> Triple:
        """Euler angles of NED and FRD, radians."""
        w, x, y, z = self.q
        return (
            math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
            math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x)))),
            math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
        )

    @property
    def heading_cdeg(self) -> int:
        """Compass heading in centidegrees, 0 to 35999."""
        return round(math.degrees(self.roll_pitch_yaw[2]) * 100) % 36000

    @property
    def ground_speed(self) -> float:
        """Horizontal, m/s."""
        return math.hypot(self.velocity[0], self.velocity[1])


def tell(earth: Earth, seen: Seen, home_site: Vector) -> Told:
    """Turn an estimate into MAVLink's frames."""
    north, east, down = earth.local(seen.position_site)
    latitude, longitude = earth.degrees(north, east)
    p, q, r = seen.rates_body.tolist()
    boot_us = round(seen.time * 1e6)
    return Told(
        boot_ms=boot_us // 1000,
        boot_us=boot_us,
        ned=(north, east, down),
        velocity=earth.turned(seen.velocity_site),
        q=earth.attitude(seen.site_from_body),
        rates=(p, -q, -r),
        latitude=latitude,
        longitude=longitude,
        altitude=earth.height - down,
        above_home=float(seen.position_site[2] - home_site[2]),
        height=seen.height,
    )
