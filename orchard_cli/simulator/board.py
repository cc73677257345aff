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

from orchard_cli.model.depth import DepthCamera, DepthFrame
from orchard_cli.model.records import TruthRecord

CLOCK_SLOTS, FRAME_SLOTS, TRUTH_SLOTS = 8, 4, 4096
CLOCK, FRAME, TRUTH = 0, 1, 2  # counters
TRUTH_ROW = 12  # time, position, velocity, attitude, whether something was touched
NAME_ROOM = 64  # bytes for the name of what was touched


class Board:
    """Clock, newest frame and truth. Hand it to the child as an argument of its process."""

    def __init__(self, context: BaseContext, camera: DepthCamera | None) -> None:
        self.camera = camera
        pixels = camera.width * camera.height if camera else 0
        make = context.RawArray
        self._counters = make("q", 3)
        self._clock = make("d", CLOCK_SLOTS * 2)
        self._stamps = make("d", FRAME_SLOTS)
        self._depth = make("H", max(FRAME_SLOTS * pixels, 1))
        self._truth = make("d", TRUTH_SLOTS * TRUTH_ROW)
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
