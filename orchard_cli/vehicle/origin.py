"""Where the autopilot's local frame lies on the earth: learnt at connecting, and watched since.

A local origin moves when the estimator starts anew, or when somebody sets another one. All of the
autopilot's coordinates then jump, and what is sent in the old ones leads astray.
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass

import mavsdk
import numpy as np
from mavsdk.plugins.telemetry import GpsGlobalOrigin, Telemetry

from orchard_cli.errors import LinkError
from orchard_cli.geometry.geodesy import site_from_wgs84
from orchard_cli.model.site import SiteOrigin

from .frames import LocalFrame

ASK_EVERY = 1.0  # s of real time
MOVED = 0.05  # m: an origin is told to 1 cm


@dataclass(frozen=True, slots=True)
class Place:
    """Where the site is, and how high the ground under the standing vehicle."""

    origin: SiteOrigin
    ground_site: float  # m


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """The local origin is somewhere else."""

    frame: LocalFrame  # where it is now
    sunk: float  # m that it is lower than before


class LocalOrigin:
    """Asks the autopilot for its global origin; a thread of its own asks again and again."""

    def __init__(self, telemetry: Telemetry, place: Place) -> None:
        self._telemetry = telemetry
        self._place = place
        self._known: GpsGlobalOrigin | None = None
        self._move: Move | None = None
        self._lock = threading.Lock()
        self._closing = threading.Event()

    def wait(self, patience: float) -> LocalFrame:
        """The local frame; an autopilot tells its origin once it has a fix, and not before.

        Raises LinkError after `patience` s of real time.
        """
        until = time.monotonic() + patience
        while True:
            try:
                self._known = self._telemetry.get_gps_global_origin()
                return self._frame(self._known)
            except mavsdk.MavsdkError:
                if time.monotonic() > until:
                    raise LinkError(
                        f"the autopilot knows no position on earth after {patience:.0f} s; "
                        "wait for a GPS fix under the open sky"
                    ) from None
                time.sleep(0.2)

    def watch(self) -> None:
        """Ask again every ASK_EVERY s until closed."""
        threading.Thread(target=self._watch, name="vehicle-origin", daemon=True).start()

    def take(self) -> Move | None:
        """The newest move that was not taken yet."""
        with self._lock:
            move, self._move = self._move, None
            return move

    def close(self) -> None:
        """Ask no more."""
        self._closing.set()

    def _watch(self) -> None:
        while not self._closing.wait(ASK_EVERY):
            try:
                self._compare(self._telemetry.get_gps_global_origin())
            except (mavsdk.MavsdkError, RuntimeError):
                continue  # a silent link, or a closed one: the flight loop sees both by itself

    def _compare(self, told: GpsGlobalOrigin) -> None:
        known, frame = self._known, self._frame(told)
        if known is None or not np.isfinite(frame.origin_site).all():
            return
        sunk = known.altitude_m - told.altitude_m
        aside = np.linalg.norm(frame.origin_site - self._frame(known).origin_site)
        if max(float(aside), abs(sunk)) < MOVED:
            return
        with self._lock:
            waiting = 0.0 if self._move is None else self._move.sunk
            self._known, self._move = told, Move(frame, sunk + waiting)

    def _frame(self, local: GpsGlobalOrigin) -> LocalFrame:
        origin = self._place.origin
        there = np.array([[local.latitude_deg, local.longitude_deg, origin.height]])
        x, y, _ = site_from_wgs84(origin, there)[0]
        return LocalFrame(origin.heading, np.array([x, y, self._place.ground_site]))
