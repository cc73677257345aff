"""The simulation itself: autopilot, camera and truth, advanced tick by tick. No input or output."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.depth import DepthCamera, DepthFrame, d455
from orchard_cli.model.records import TruthRecord
from orchard_cli.model.sensors import (
    Beams,
    ColourFrame,
    Radar,
    RadarScan,
    RangeScan,
    SensorScan,
    corner_lasers,
    plant_protection_radar,
)
from orchard_cli.model.world import World

from .autopilot import TICK, Autopilot
from .failing import FailingCamera
from .faults import (
    Appearance,
    BatteryDrop,
    CameraFault,
    ClockStep,
    EstimateJump,
    GpsLoss,
    OriginMove,
    SimulatedFault,
    WindChange,
)
from .feeler import Feeler
from .scene import Scene
from .sensors import RadarModel, RangeModel
from .settings import SimulatorSettings

COLOUR_RATE = 5.0  # Hz: drawing in colour takes several times as long as in depth
TRUTH_EVERY = 2  # ticks: 50 Hz; contact is looked for as often


@dataclass(frozen=True, slots=True, eq=False)
class Due:
    """What fell due in one tick."""

    truth: TruthRecord | None
    frame: DepthFrame | None
    scans: tuple[SensorScan, ...] = ()


def mounted(settings: SimulatorSettings) -> tuple[Radar | None, Beams | None]:
    """The radar and the lasers on the vehicle, as far as they are asked for."""
    arm = settings.kit.airframe.arm
    radar = plant_protection_radar(arm) if "radar" in settings.sensors else None
    return radar, corner_lasers(arm) if "range" in settings.sensors else None


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
            airframe=settings.kit.airframe,
            pack=settings.pack or settings.kit.pack,
            parameters={**settings.kit.parameters, **settings.parameters},
            level=settings.kit.level,
        )
        self.camera: DepthCamera | None = d455(*settings.camera) if settings.camera else None
        radar, beams = mounted(settings)
        self._radar = None if radar is None else RadarModel(self._scene, radar)
        self._lasers = None if beams is None else RangeModel(self._scene, beams)
        self._colour = "colour" in settings.sensors and self.camera is not None
        self._scans = self._colour or radar is not None or beams is not None
        self._frame_rate = settings.frame_rate
        self._feeler = Feeler(self._scene, settings.kit.airframe.radius)
        self._failing = FailingCamera()
        self._fix_back = math.inf  # s, when a lost GPS fix comes back
        self._frames = self._sweeps = self._shots = self._pictures = 0
        self._ticks = 0
        self._contact = ""  # what was touched first; nothing is touched twice

    @property
    def time(self) -> float:
        """Simulated seconds since boot."""
        return self.autopilot.time

    def inject(self, fault: SimulatedFault) -> None:
        """Make something go wrong from the next tick on."""
        craft = self.autopilot.craft
        match fault:
            case CameraFault():
                self._failing.inject(fault, self.time)
            case GpsLoss():
                self.autopilot.set_gps_fix(False)
                self._fix_back = self.time + fault.seconds
            case WindChange():
                craft.set_wind(np.array(fault.velocity_site))
            case BatteryDrop():
                craft.battery.share = min(craft.battery.share, fault.share)
            case EstimateJump():
                craft.jump_estimate(np.array(fault.moved_site), fault.turned)
            case Appearance():
                world = self._scene.world
                self._scene = Scene(dataclasses.replace(world, poles=(*world.poles, fault.pole)))
                self._feeler = Feeler(self._scene, craft.body.airframe.radius)
            case OriginMove() | ClockStep():
                raise ValueError("there are no origin and no stamps of its own without MAVLink")

    def step(self) -> Due:
        """Fly one tick; the truth, the frame and the scans that fell due in it."""
        self.autopilot.step()
        self._ticks += 1
        if self.time >= self._fix_back:
            self.autopilot.set_gps_fix(True)
            self._fix_back = math.inf
        truth = None
        if self._ticks % TRUTH_EVERY == 0:
            self._touch()
            truth = self._truth()
        looks = self.camera is not None and self._is_due(self._frame_rate, self._frames)
        scans = (self._sweep(), self._shoot(), self._picture()) if self._scans else ()
        found = tuple(scan for scan in scans if scan is not None)
        return Due(truth, self._frame() if looks else None, found)

    def _is_due(self, rate: float, taken: int) -> bool:
        return self._ticks * TICK * rate >= taken + 1

    def _touch(self) -> None:
        """What the airframe touches in the air breaks its rotors; the autopilot is not told."""
        body = self.autopilot.craft.body
        if self._contact or not body.airborne:
            return
        touched = self._feeler.touched(body.position_site, self.time)
        if touched is not None:
            self._contact = touched
            body.break_rotors()

    def _truth(self) -> TruthRecord:
        body = self.autopilot.craft.body
        return TruthRecord(
            self.time, body.position_site, body.velocity_site, body.site_from_body, self._contact
        )

    def _frame(self) -> DepthFrame | None:
        assert self.camera is not None
        self._frames += 1
        body = self.autopilot.craft.body
        depth = self._scene.render(
            self.camera, body.position_site, body.site_from_body, self.time, self._frames
        )
        spoilt = self._failing.spoil(depth, self._frames, self.time)
        return None if spoilt is None else DepthFrame(self.time, spoilt, self.camera)

    def _sweep(self) -> RadarScan | None:
        if self._radar is None or not self._is_due(self._radar.radar.rate, self._sweeps):
            return None
        self._sweeps += 1
        body = self.autopilot.craft.body
        return self._radar.scan(
            body.position_site, body.velocity_site, body.site_from_body, self.time, self._sweeps
        )

    def _shoot(self) -> RangeScan | None:
        if self._lasers is None or not self._is_due(self._lasers.beams.rate, self._shots):
            return None
        self._shots += 1
        body = self.autopilot.craft.body
        return self._lasers.scan(body.position_site, body.site_from_body, self.time, self._shots)

    def _picture(self) -> ColourFrame | None:
        if not self._colour or not self._is_due(COLOUR_RATE, self._pictures):
            return None
        assert self.camera is not None
        self._pictures += 1
        body = self.autopilot.craft.body
        rgb = self._scene.colours(
            self.camera, body.position_site, body.site_from_body, self.time, self._pictures
        )
        return ColourFrame(self.time, rgb, self.camera)
