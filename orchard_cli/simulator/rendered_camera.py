"""A simulated camera on a vehicle that is flown by somebody else: an autopilot on the bench.

It sees a world file from wherever the vehicle says that it is. For a real PX4 in its own
simulation, and for hardware on a desk; never for a flight among real things.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from orchard_cli.model.depth import DepthCamera, DepthFrame
from orchard_cli.model.vehicle import Pose
from orchard_cli.model.world import World

from .scene import Scene


class RenderedCamera:
    """Fits flight/ports.py `Camera`; draws in a thread of its own."""

    def __init__(
        self, world: World, model: DepthCamera, rate: float, newest: Callable[[], Pose | None]
    ) -> None:
        """`newest` tells the vehicle's newest pose; `rate` in frames per second of real time."""
        self.model = model
        self._scene = Scene(world)
        self._newest = newest
        self._period = 1.0 / rate
        self._frame: DepthFrame | None = None
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._draw, name="rendered-camera", daemon=True)
        self._thread.start()

    def latest(self) -> DepthFrame | None:
        """The newest frame, once."""
        frame, self._frame = self._frame, None
        return frame

    def close(self) -> None:
        """Stop drawing."""
        self._stopping.set()
        self._thread.join(timeout=2.0)

    def _draw(self) -> None:
        number = 0
        while not self._stopping.is_set():
            began = time.monotonic()
            pose = self._newest()
            if pose is not None:
                depth = self._scene.render(
                    self.model, pose.position_site, pose.site_from_body, pose.time, number
                )
                self._frame = DepthFrame(pose.time, depth, self.model)
                number += 1
            self._stopping.wait(max(self._period - (time.monotonic() - began), 0.001))
