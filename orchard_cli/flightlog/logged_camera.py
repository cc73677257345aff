"""The eyes of a flight that was logged: another flight along the same way sees what that one saw.

Images are found by place, not by time, so that a slower or a faster flight sees the right ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import zstandard
from numpy.typing import NDArray

from orchard_cli.errors import Fault, InputError
from orchard_cli.flightlog.frames import depth_frames
from orchard_cli.flightlog.reader import read
from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.depth import DepthCamera, DepthFrame
from orchard_cli.model.vehicle import Pose

BESIDE = 0.4  # m between where the vehicle is and where an image was taken, at most
TURNED = math.radians(8.0)  # between how it looks and how the image was taken, at most
AGAIN = 0.35  # s after which a vehicle that passes no new image is shown the nearest once more
LARGEST = 1_000_000_000  # bytes of packed images
_PER_RADIAN = 1.0  # m of distance that a radian counts as


@dataclass(frozen=True, slots=True, eq=False)
class Album:
    """The depth images of a log, packed, with where the body was at each."""

    camera: DepthCamera
    images: Sequence[bytes]  # n, zstd
    positions_site: Points  # (n, 3) m
    site_from_body: Array  # (n, 4) quaternions w, x, y, z

    def depth(self, k: int) -> NDArray[np.uint16]:
        """Depth image k, mm."""
        data = zstandard.ZstdDecompressor().decompress(self.images[k])
        return np.frombuffer(data, dtype="<u2").reshape(self.camera.height, self.camera.width)

    def nearest(self, pose: Pose) -> tuple[int, float] | None:
        """The image taken nearest to a pose, and how far off it is, m; None where none is near."""
        away = np.linalg.norm(self.positions_site - pose.position_site, axis=1)
        turned = 2 * np.arccos(np.clip(np.abs(self.site_from_body @ pose.site_from_body), 0, 1))
        cost = np.where((away <= BESIDE) & (turned <= TURNED), away + _PER_RADIAN * turned, np.inf)
        k = int(cost.argmin())
        return (k, float(cost[k])) if np.isfinite(cost[k]) else None


def album(path: Path) -> Album:
    """Every depth image of a log. Raises InputError where there are none, or too many."""
    track = read(path, {"/odometry"}).odometry
    pack = zstandard.ZstdCompressor(level=1).compress
    times, images, camera, room = [], [], None, LARGEST
    for frame in depth_frames(path):
        if not len(track.times) or not track.times[0] <= frame.time <= track.times[-1]:
            continue
        if camera is not None and frame.depth_mm.shape != (camera.height, camera.width):
            raise InputError(Fault(str(path), "changes the size of its images", "name another log"))
        camera = frame.camera
        times.append(frame.time)
        images.append(pack(frame.depth_mm.tobytes()))
        room -= len(images[-1])
        if room < 0:
            what = f"holds more than {LARGEST / 1e9:g} GB of images"
            raise InputError(Fault(str(path), what, "name a shorter one"))
    if camera is None:
        what = "holds no depth images of where it flew"
        raise InputError(Fault(str(path), what, "name a log of a flight with a camera"))
    here = np.clip(np.searchsorted(track.times, times), 0, len(track.times) - 1)
    places = [np.interp(times, track.times, axis) for axis in track.positions_site.T]
    return Album(camera, images, np.column_stack(places), track.site_from_body[here])


@dataclass(slots=True)
class _Near:
    """The image that the vehicle is approaching or leaving."""

    image: int
    cost: float  # m, the least so far
    pose: Pose  # where that was
    shown: bool = False


class LoggedCamera:
    """Fits flight/ports.py `Camera`.

    An image is shown when the vehicle has passed the place where it was taken, with the time of
    passing. One that stands is shown the nearest image again and again; away from all of them it
    sees nothing, and the flight holds as it does whenever its camera is silent.
    """

    def __init__(self, album: Album, poses: Callable[[float], tuple[Pose, ...]]) -> None:
        """`poses` tells those measured after a time, oldest first."""
        self.model = album.camera
        self._album, self._poses = album, poses
        self._followed = -math.inf  # time of the last pose that was looked at
        self._near: _Near | None = None
        self._due: tuple[int, float] | None = None  # image and time, to be handed out
        self._shown = -math.inf  # time of the last image

    def latest(self) -> DepthFrame | None:
        """The newest image that was passed since the last call, or None."""
        for pose in self._poses(self._followed):
            self._followed = pose.time
            self._follow(pose)
        if self._due is None:
            return None
        (image, time), self._due = self._due, None
        return DepthFrame(time, self._album.depth(image), self.model)

    def close(self) -> None:
        """Nothing to let go of."""

    def _follow(self, pose: Pose) -> None:
        found = self._album.nearest(pose)
        near = self._near
        if near is not None and (found is None or found[0] != near.image or found[1] > near.cost):
            self._show(near)
        if found is None:
            self._near = None
            return
        if near is None or found[0] != near.image:
            self._near = _Near(*found, pose)
        elif found[1] < near.cost:
            near.cost, near.pose = found[1], pose
        if pose.time - self._shown >= AGAIN:
            self._due, self._shown = (found[0], pose.time), pose.time

    def _show(self, near: _Near) -> None:
        """Once, unless a later one was shown meanwhile."""
        if not near.shown and near.pose.time > self._shown:
            self._due, self._shown = (near.image, near.pose.time), near.pose.time
        near.shown = True
