"""The frame that is worked on next."""

from __future__ import annotations

import math

from orchard_cli.model.depth import DepthFrame

PATIENCE = 0.3  # s that a frame waits for a pose that is as new as itself
AHEAD = 0.05  # s that a frame may be ahead of the flight clock


class Inbox:
    """Keeps one frame until the pose at its time is known, then hands it out once.

    Telemetry is older than the frames by the link's latency. A frame that waits is not replaced
    by newer ones, or on a slow link none would ever be mapped.
    """

    def __init__(self) -> None:
        self._waiting: DepthFrame | None = None
        self.newest = -math.inf  # s, stamp of the newest usable frame

    def put(self, frame: DepthFrame, now: float) -> bool:
        """Take a good frame; False when it cannot be used: stamped in the future."""
        if frame.time > now + AHEAD:
            return False
        self.newest = max(self.newest, frame.time)
        if self._waiting is None or now - self._waiting.time > PATIENCE:
            self._waiting = frame
        return True

    def take(self, pose_time: float) -> DepthFrame | None:
        """The waiting frame, when poses up to `pose_time` cover it."""
        if self._waiting is None or pose_time < self._waiting.time:
            return None
        frame, self._waiting = self._waiting, None
        return frame
