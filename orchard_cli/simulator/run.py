"""The simulation itself: autopilot, camera and truth, advanced tick by tick. No input or output."""

from __future__ import annotations

import dataclasses

from orchard_cli.model.depth import DepthCamera, DepthFrame, d455
from orchard_cli.model.records import TruthRecord
from orchard_cli.model.world import World

from .autopilot import TICK, Autopilot
from .scene import Scene
from .settings import SimulatorSettings

TRUTH_EVERY = 2  # ticks: 50 Hz; contact is looked for as often


class Run:
    """One simulated flight. The same world, start, settings and calls give the same bits."""

    def __init__(
        self,
        world: World,
        start_site: tuple[float, float],
        start_yaw_site: float,
        settings: SimulatorSettings,
    ) -> None:
        if settings.seed is not None:
            world = dataclasses.replace(world, seed=settings.seed)
        self._scene = Scene(world)
        a, b, c = self._scene.ground.tolist()
        self.autopilot = Autopilot(
            world,
            start_site,
            start_yaw_site,
            ground=(a, b, c),
            pack=settings.pack,
            parameters=settings.parameters,
        )
        self.camera: DepthCamera | None = d455(*settings.camera) if settings.camera else None
        self._frame_rate = settings.frame_rate
        self._frames = 0
        self._ticks = 0
        self._contact = ""  # what was touched first; nothing is touched twice

    @property
    def time(self) -> float:
        """Simulated seconds since boot."""
        return self.autopilot.time

    def step(self) -> tuple[TruthRecord | None, DepthFrame | None]:
        """Fly one tick; the truth and the frame that fell due in it."""
        self.autopilot.step()
        self._ticks += 1
        truth = None
        if self._ticks % TRUTH_EVERY == 0:
            self._touch()
            truth = self._truth()
        due = self.camera is not None and self._ticks * TICK * self._frame_rate >= self._frames + 1
        return truth, self._frame() if due else None

    def _touch(self) -> None:
        """What the airframe touches in the air breaks its rotors; the autopilot is not told."""
        body = self.autopilot.craft.body
        if self._contact or not body.airborne:
            return
        touched = self._scene.contact(body.position_site, body.airframe.radius, self.time)
        if touched is not None:
            self._contact = touched
            body.break_rotors()

    def _truth(self) -> TruthRecord:
        body = self.autopilot.craft.body
        return TruthRecord(
            self.time, body.position_site, body.velocity_site, body.site_from_body, self._contact
        )

    def _frame(self) -> DepthFrame:
        assert self.camera is not None
        self._frames += 1
        body = self.autopilot.craft.body
        depth = self._scene.render(
            self.camera, body.position_site, body.site_from_body, self.time, self._frames
        )
        return DepthFrame(self.time, depth, self.camera)
