"""Radar and lasers as an autopilot passes them on: OBSTACLE_DISTANCE and DISTANCE_SENSOR.

MAVSDK's telemetry has no sensor's id, so the messages are taken as they are. What cannot be had:
OBSTACLE_DISTANCE has one range for each direction, so neither elevation nor speed. The lasers S1 to
S4 are the distance sensors with the ids 1 to 4, and must point where Ahmed 2022 has them.
"""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from mavsdk.plugins.mavlink_direct import MavlinkDirect

from orchard_cli.model.sensors import (
    Beams,
    Radar,
    RadarScan,
    RangeScan,
    Sensed,
    plant_protection_radar,
)

BODY_FRD = 12  # MAV_FRAME
UNKNOWN = 65535  # cm: this direction is not measured
INVALID = 1  # signal_quality: the measurement is worth nothing
POINTING = {1: 0, 2: 6, 3: 0, 4: 2}  # id -> MAV_SENSOR_ORIENTATION: ahead, left, ahead, right
TOGETHER = 0.3  # s within which all four lasers must have spoken to make one scan

Fields = Mapping[str, Any]


class Rangefinders:
    """Fits flight/ports.py `Sensors`. Scans carry the time of their arrival."""

    def __init__(self, system: Any, now: Callable[[], float], arm: float, beams: Beams) -> None:
        """`arm`: m from the body's centre to the radar before it."""
        self._now = now
        self._beams = beams
        self._radar = plant_protection_radar(arm)
        self._lock = threading.Lock()
        self._sensed = Sensed()
        self._lasers: dict[int, tuple[float, float]] = {}  # id -> time, m
        self._direct = MavlinkDirect(system)
        self._direct.subscribe_message("OBSTACLE_DISTANCE", self._obstacles)
        self._direct.subscribe_message("DISTANCE_SENSOR", self._laser)

    def newest(self) -> Sensed:
        """The newest scan of each sensor."""
        with self._lock:
            return self._sensed

    def close(self) -> None:
        """Hear nothing any more."""
        self._direct.destroy()

    def _obstacles(self, message: Any, _: Any) -> None:
        scan = radar_scan(json.loads(message.fields_json), self._radar, self._now())
        if scan is not None:
            with self._lock:
                self._sensed = self._sensed.after(scan)

    def _laser(self, message: Any, _: Any) -> None:
        measured = laser_range(json.loads(message.fields_json))
        if measured is None:
            return
        number, far = measured
        with self._lock:
            self._lasers[number] = (self._now(), far)
            scan = range_scan(self._lasers, self._beams)
            if scan is not None:
                self._sensed = self._sensed.after(scan)


def radar_scan(fields: Fields, radar: Radar, now: float) -> RadarScan | None:
    """OBSTACLE_DISTANCE as reflections at the vehicle's height; None when it is not of the body.

    Directions count clockwise from ahead; a range of max_distance + 1 says that there is nothing.
    """
    if int(fields["frame"]) != BODY_FRD:
        return None
    ranges = np.asarray(fields["distances"], dtype=np.float64)
    step = float(fields.get("increment_f") or 0.0) or float(fields["increment"])
    clockwise = np.radians(float(fields.get("angle_offset") or 0.0) + step * np.arange(len(ranges)))
    azimuths = np.arctan2(np.sin(-clockwise), np.cos(-clockwise))
    seen = (ranges >= float(fields["min_distance"])) & (ranges <= float(fields["max_distance"]))
    seen &= (ranges != UNKNOWN) & (np.abs(azimuths) <= radar.width / 2 + 1e-6)
    rows = np.full((int(seen.sum()), 4), math.nan)
    rows[:, 0], rows[:, 1], rows[:, 2] = ranges[seen] / 100, azimuths[seen], 0.0
    return RadarScan(now, rows, radar)


def laser_range(fields: Fields) -> tuple[int, float] | None:
    """DISTANCE_SENSOR -> id and range in m, inf for nothing; None when it is none of the four."""
    number = int(fields["id"])
    if POINTING.get(number) != int(fields["orientation"]):
        return None
    if int(fields.get("signal_quality") or 0) == INVALID:
        return None
    far = float(fields["current_distance"])
    return number, math.inf if far >= float(fields["max_distance"]) else far / 100


def range_scan(lasers: Mapping[int, tuple[float, float]], beams: Beams) -> RangeScan | None:
    """All four together, as old as the oldest; None when one of them has fallen silent."""
    if set(lasers) != set(POINTING):
        return None
    times = [time for time, _ in lasers.values()]
    if max(times) - min(times) > TOGETHER:
        return None
    return RangeScan(min(times), np.array([lasers[number][1] for number in (1, 2, 3, 4)]), beams)
