"""From images to obstacles: a detector's boxes, each with its distance, size and place."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.obstacles import Detection, Sighting
from orchard_cli.model.sensors import ColourFrame
from orchard_cli.model.vehicle import Pose

from .distance import distance
from .fusion import fuse
from .rays import Rays


class Detector(Protocol):
    """Finds things in images."""

    needs: frozenset[str]  # sensors besides depth, of model/sensors.py SENSORS

    def detect(
        self, frame: DepthFrame, pose: Pose, colour: ColourFrame | None
    ) -> tuple[Detection, ...]:
        """Boxes in the pixels of the depth frame, which was taken at a pose of the body."""
        ...


@dataclass(frozen=True, slots=True)
class EyesSettings:
    """What is believed."""

    score: float = 0.4  # least
    trusted: float = math.inf  # m of depth beyond which a thing is known by its category alone


class RgbdEyes:
    """A detector and a depth camera (Wang 2020, Fig. 1). Remembers nothing."""

    def __init__(self, detector: Detector, settings: EyesSettings | None = None) -> None:
        self._detector = detector
        self._settings = settings or EyesSettings()
        self.needs = detector.needs

    def look(self, frame: DepthFrame, pose: Pose, colour: ColourFrame | None) -> Sighting:
        """Everything that is seen in a frame; what has no depth within reach is a glimpse."""
        s, rays = self._settings, Rays.of(frame.camera, pose)
        obstacles, glimpses = [], []
        for detection in self._detector.detect(frame, pose, colour):
            if detection.score < s.score:
                continue
            there = distance(detection, frame.depth_mm, frame.camera.range_min, s.trusted)
            if there is None:
                glimpses.append(detection)
            else:
                obstacles.append(fuse(detection, there, rays))
        return Sighting(tuple(obstacles), tuple(glimpses))
