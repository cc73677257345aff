"""What the simulator's process shows to the one that started it, in shared memory without locks.

One writer, one reader. The writer fills a slot of a ring and then raises a counter; the reader
copies the newest slot and then looks whether the counter has come so far that the slot may have
been written again. No lock, so a process that dies leaves none held.
"""

from __future__ import annotations

import time
from multiprocessing.context import BaseContext
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.arrays import Array
from orchard_cli.model.depth import DepthCamera, DepthFrame
from orchard_cli.model.records import TruthRecord
from orchard_cli.model.sensors import (
    Beams,
    ColourFrame,
    Radar,
    RadarScan,
    RangeScan,
    Sensed,
    SensorScan,
)

CLOCK_SLOTS, FRAME_SLOTS, TRUTH_SLOTS, SCAN_SLOTS = 8, 4, 4096, 8
CLOCK, FRAME, TRUTH, RADAR, RANGE, COLOUR = 0, 1, 2, 3, 4, 5  # counters
RADAR_ROOM = 256  # reflections; a scan with more loses the last
TRUTH_ROW = 12  # time, position, velocity, attitude, whether something was touched
NAME_ROOM = 64  # bytes for the name of what was touched


class Board:
    """Clock, newest frame and scans, truth. Hand it to the child as an argument of its process."""

    def __init__(
        self,
        context: BaseContext,
        camera: DepthCamera | None,
        mounted: tuple[Radar | None, Beams | None] = (None, None),
        colour: bool = False,
    ) -> None:
        self.camera = camera
        self._radar, self._beams = mounted
        pixels = camera.width * camera.height if camera else 0
        make = context.RawArray
        self._counters = make("q", 6)
        self._clock = make("d", CLOCK_SLOTS * 2)
        self._stamps = make("d", FRAME_SLOTS)
        self._depth = make("H", max(FRAME_SLOTS * pixels, 1))
        self._truth = make("d", TRUTH_SLOTS * TRUTH_ROW)
        beams = len(self._beams.names) if self._beams else 0
        self._reflections = make("d", SCAN_SLOTS * (2 + 4 * RADAR_ROOM))  # time, count, rows
        self._ranges = make("d", SCAN_SLOTS * (1 + beams))  # time, metres
        self._colour = make("B", max(FRAME_SLOTS * 3 * pixels if colour else 0, 1))
        self._colour_stamps = make("d", FRAME_SLOTS)
        self._contact = make("c", NAME_ROOM)  # written once, before the first row that says so
        self._achieved = make("d", 1)

    def _view(self, name: str, kind: Any, rows: int) -> NDArray[Any]:
        return np.frombuffer(getattr(self, name), dtype=kind).reshape(rows, -1)

    # -- the simulator's side

    def set_clock(self, now: float) -> None:
        """The simulation has reached `now`."""
        n = self._counters[CLOCK] + 1
        slot = n % CLOCK_SLOTS
        self._clock[2 * slot] = now
        self._clock[2 * slot + 1] = time.monotonic()
        self._counters[CLOCK] = n

    def put_frame(self, frame: DepthFrame) -> None:
        """Show a frame."""
        n = self._counters[FRAME] + 1
        self._view("_depth", np.uint16, FRAME_SLOTS)[n % FRAME_SLOTS] = frame.depth_mm.reshape(-1)
        self._stamps[n % FRAME_SLOTS] = frame.time
        self._counters[FRAME] = n

    def put_scan(self, scan: SensorScan) -> None:
        """Show a radar or laser scan."""
        match scan:
            case RadarScan():
                n = self._counters[RADAR] + 1
                rows = scan.returns[:RADAR_ROOM]
                slot = self._view("_reflections", np.float64, SCAN_SLOTS)[n % SCAN_SLOTS]
                slot[:2], slot[2 : 2 + rows.size] = (scan.time, len(rows)), rows.reshape(-1)
                self._counters[RADAR] = n
            case RangeScan():
                n = self._counters[RANGE] + 1
                slot = self._view("_ranges", np.float64, SCAN_SLOTS)[n % SCAN_SLOTS]
                slot[0], slot[1:] = scan.time, scan.ranges
                self._counters[RANGE] = n
            case ColourFrame():
                n = self._counters[COLOUR] + 1
                slots = self._view("_colour", np.uint8, FRAME_SLOTS)
                slots[n % FRAME_SLOTS] = scan.rgb.reshape(-1)
                self._colour_stamps[n % FRAME_SLOTS] = scan.time
                self._counters[COLOUR] = n

    def put_truth(self, record: TruthRecord) -> None:
        """Show where the vehicle really is."""
        n = self._counters[TRUTH] + 1
        row = self._view("_truth", np.float64, TRUTH_SLOTS)[n % TRUTH_SLOTS]
        row[0], row[1:4], row[4:7] = record.time, record.position_site, record.velocity_site
        row[7:11], row[11] = record.site_from_body, bool(record.contact)
        if record.contact and not self._contact.value:
            self._contact.value = record.contact.encode()
        self._counters[TRUTH] = n

    def set_achieved(self, factor: float) -> None:
        """How fast the simulation has been running, simulated seconds per real second."""
        self._achieved[0] = factor

    # -- the other side

    @property
    def achieved(self) -> float:
        """Simulated seconds per real second since the start."""
        return float(self._achieved[0])

    def clock(self) -> tuple[float, float]:
        """Simulated time, and the monotonic real time at which it was reached."""
        while True:
            n = self._counters[CLOCK]
            slot = n % CLOCK_SLOTS
            pair = self._clock[2 * slot], self._clock[2 * slot + 1]
            if self._counters[CLOCK] - n < CLOCK_SLOTS - 1:
                return pair

    def frame(self, after: int) -> tuple[int, DepthFrame | None]:
        """The newest frame's number, and the frame itself when its number is above `after`."""
        while True:
            n = int(self._counters[FRAME])
            if n <= after or self.camera is None:
                return n, None
            camera = self.camera
            depth = self._view("_depth", np.uint16, FRAME_SLOTS)[n % FRAME_SLOTS].copy()
            stamp = float(self._stamps[n % FRAME_SLOTS])
            if self._counters[FRAME] - n < FRAME_SLOTS - 1:
                return n, DepthFrame(stamp, depth.reshape(camera.height, camera.width), camera)

    def sensed(self) -> Sensed:
        """The newest scans."""
        sweep, shot = self._newest("_reflections", RADAR), self._newest("_ranges", RANGE)
        radar = ranges = None
        if sweep is not None and self._radar is not None:
            rows = sweep[2 : 2 + 4 * int(sweep[1])].reshape(-1, 4)
            radar = RadarScan(float(sweep[0]), rows, self._radar)
        if shot is not None and self._beams is not None:
            ranges = RangeScan(float(shot[0]), shot[1:], self._beams)
        return Sensed(radar, ranges, self._newest_colour())

    def _newest_colour(self) -> ColourFrame | None:
        while True:
            n, camera = int(self._counters[COLOUR]), self.camera
            if n == 0 or camera is None:
                return None
            slot = self._view("_colour", np.uint8, FRAME_SLOTS)[n % FRAME_SLOTS]
            rgb = slot.reshape(camera.height, camera.width, 3).copy()
            stamp = float(self._colour_stamps[n % FRAME_SLOTS])
            if self._counters[COLOUR] - n < FRAME_SLOTS - 1:
                return ColourFrame(stamp, rgb, camera)

    def _newest(self, name: str, counter: int) -> Array | None:
        """A copy of a ring's newest slot; None before the first."""
        while True:
            n = int(self._counters[counter])
            if n == 0:
                return None
            slot: Array = self._view(name, np.float64, SCAN_SLOTS)[n % SCAN_SLOTS].copy()
            if self._counters[counter] - n < SCAN_SLOTS - 1:
                return slot

    def truth(self, after: int) -> tuple[int, tuple[TruthRecord, ...]]:
        """Records after number `after`, oldest first; those overwritten meanwhile are lost."""
        n = int(self._counters[TRUTH])
        first = max(after + 1, n - TRUTH_SLOTS // 2)
        rows = self._view("_truth", np.float64, TRUTH_SLOTS)
        taken = [rows[k % TRUTH_SLOTS].copy() for k in range(first, n + 1)]
        contact = self._contact.value.decode()
        return n, tuple(
            TruthRecord(float(row[0]), row[1:4], row[4:7], row[7:11], contact if row[11] else "")
            for row in taken
        )
