"""An Intel RealSense depth camera (D455, D435) behind the camera socket.

The only file that imports pyrealsense2, the vendor's library (extra `realsense`). A frame's time is
the middle of its exposure on the flight clock, so that the map can take the pose of that instant.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchard_cli.errors import LinkError
from orchard_cli.model.depth import DepthCamera, DepthFrame

from .mount import Mount

Now = Callable[[], float]
FIRST_FRAME = 5.0  # s of real time for the first frame
OLDEST = 1.0  # s: an older frame's clock is not the computer's
_INSTALL = "install it with: pip install 'orchard-cli[realsense]' (and the system's libusb-1.0)"


@dataclass(frozen=True, slots=True)
class RealSenseSettings:
    """How the camera is run.

    The vendor's filters are off: the spatial one smooths, and rounds off thin poles; hole filling
    invents surfaces where the camera saw none, which may close a free way, or hide what is behind.
    """

    width: int = 848
    height: int = 480
    rate: int = 30  # Hz
    range_min: float = 0.6  # m, of a D455; a D435 sees from 0.3 m
    range_max: float = 6.0  # m
    spatial: bool = False
    fill_holes: bool = False
    serial: str = ""  # of the camera to use; empty: the only one


@dataclass(frozen=True, slots=True)
class Found:
    """One camera that is plugged in."""

    name: str
    serial: str
    firmware: str
    usb: str


def find() -> tuple[Found, ...]:
    """Cameras that are plugged in. Raises LinkError when the vendor's library is missing."""
    rs = _library()
    info = rs.camera_info
    return tuple(
        Found(*(_told(device, kind) for kind in
                (info.name, info.serial_number, info.firmware_version, info.usb_type_descriptor)))
        for device in rs.context().query_devices()
    )  # fmt: skip


class RealSense:
    """Fits flight/ports.py `Camera`. Frames come in the vendor's thread; the newest is kept."""

    def __init__(
        self,
        settings: RealSenseSettings,
        mount: Mount,
        now: Now,
        *,
        device: Any = None,
        patience: float = FIRST_FRAME,
    ) -> None:
        """Start streaming and wait for the first frame, at most `patience` s.

        `device` is for a device of the vendor's library that was opened already. Raises LinkError
        when there is no such camera or mode, or no frame comes.
        """
        self._rs = _library()
        self._now = now
        self._frame: DepthFrame | None = None
        self._first = threading.Event()
        self.trouble = ""  # why the last frame could not be used
        device = _open(self._rs, settings.serial) if device is None else device
        self._sensor = device.first_depth_sensor()
        profile = _profile(self._rs, self._sensor, settings)
        self.model = _model(self._rs, profile, settings, mount)
        self._units = float(self._sensor.get_option(self._rs.option.depth_units)) * 1e3  # mm
        self._filters = _filters(self._rs, settings)
        self._sensor.open(profile)
        self._sensor.start(self._take)
        if not self._first.wait(patience):
            self.close()
            why = self.trouble or "is it on a USB 3 port?"
            raise LinkError(f"the camera gave no usable frame within {patience:.0f} s: {why}")

    def latest(self) -> DepthFrame | None:
        """The newest frame, once."""
        frame, self._frame = self._frame, None
        return frame

    def close(self) -> None:
        """Stop streaming."""
        for act in (self._sensor.stop, self._sensor.close):
            try:
                act()
            except RuntimeError:  # unplugged, or stopped already
                continue

    def _take(self, frame: Any) -> None:
        """Keep one frame; an unusable one only leaves word why."""
        arrived, utc = self._now(), time.time()
        age = utc - self._exposed(frame)
        if frame.get_frame_timestamp_domain() == self._rs.timestamp_domain.hardware_clock:
            self.trouble = "its frames carry the camera's own clock; update firmware and kernel"
            return
        if not 0.0 <= age < OLDEST:
            self.trouble = f"its frames are {age:.2f} s old by the computer's clock"
            return
        for step in self._filters:
            frame = step.process(frame)
        self._frame = DepthFrame(arrived - age, self._millimetres(frame), self.model)
        self._first.set()

    def _millimetres(self, frame: Any) -> NDArray[np.uint16]:
        """A copy in mm: the library's buffers are used again."""
        raw: NDArray[np.uint16] = np.asanyarray(frame.get_data())
        if self._units == 1.0:
            return raw.copy()
        scaled = np.rint(raw * self._units)
        return np.where(scaled < 2**16, scaled, 0).astype(np.uint16)

    def _exposed(self, frame: Any) -> float:
        """UTC, s, of the middle of the exposure; of the frame itself without its metadata."""
        stamp, kinds = float(frame.get_timestamp()) / 1e3, self._rs.frame_metadata_value
        pair = (kinds.frame_timestamp, kinds.sensor_timestamp)
        if not all(frame.supports_frame_metadata(kind) for kind in pair):
            return stamp
        sent, exposed = (frame.get_frame_metadata(kind) for kind in pair)  # µs, camera's clock
        return stamp - float(sent - exposed) / 1e6


def _library() -> Any:
    try:
        import pyrealsense2
    except ImportError as error:
        raise LinkError(f"pyrealsense2 is not usable ({error}); {_INSTALL}") from None
    return pyrealsense2


def _told(device: Any, kind: Any) -> str:
    return str(device.get_info(kind)) if device.supports(kind) else "unknown"


def _open(rs: Any, serial: str) -> Any:
    devices = [d for d in rs.context().query_devices()
               if serial in ("", _told(d, rs.camera_info.serial_number))]  # fmt: skip
    if not devices:
        which = f" with serial number {serial}" if serial else ""
        raise LinkError(f"no RealSense camera{which} is plugged in; see `orchard doctor`")
    if len(devices) > 1:
        found = ", ".join(_told(d, rs.camera_info.serial_number) for d in devices)
        raise LinkError(f"several RealSense cameras are plugged in ({found}); name one's serial")
    return devices[0]


def _profile(rs: Any, sensor: Any, settings: RealSenseSettings) -> Any:
    """The depth stream that was asked for; LinkError with what there is instead."""
    modes = [
        (profile, profile.as_video_stream_profile())
        for profile in sensor.get_stream_profiles()
        if profile.stream_type() == rs.stream.depth and profile.format() == rs.format.z16
    ]
    for profile, video in modes:
        if (video.width(), video.height(), video.fps()) == (
            settings.width, settings.height, settings.rate,
        ):  # fmt: skip
            return profile
    known = sorted({f"{v.width()}x{v.height()} at {v.fps()} Hz" for _, v in modes})
    raise LinkError(
        f"the camera has no mode {settings.width}x{settings.height} at {settings.rate} Hz; "
        f"it has {', '.join(known) or 'no depth stream'}"
    )


def _model(rs: Any, profile: Any, settings: RealSenseSettings, mount: Mount) -> DepthCamera:
    """The camera's own calibration; its depth images are rectified, or it is refused."""
    lens = profile.as_video_stream_profile().get_intrinsics()
    if any(lens.coeffs) and lens.model != rs.distortion.none:
        raise LinkError("the camera's depth image is distorted; only rectified depth can be mapped")
    return DepthCamera(
        lens.width, lens.height, lens.fx, lens.fy, lens.ppx, lens.ppy,
        settings.range_min, settings.range_max, mount.body_from_camera, mount.position_body,
    )  # fmt: skip


def _filters(rs: Any, settings: RealSenseSettings) -> tuple[Any, ...]:
    """The vendor's filters that were asked for, in the vendor's order."""
    chosen = []
    if settings.spatial:  # works on disparity, as the vendor advises
        chosen += [rs.disparity_transform(True), rs.spatial_filter(), rs.disparity_transform(False)]
    if settings.fill_holes:
        chosen.append(rs.hole_filling_filter())
    return tuple(chosen)
