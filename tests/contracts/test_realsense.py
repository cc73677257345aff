"""The RealSense driver, fed by the vendor's own software device: no hardware, the real library."""

from __future__ import annotations

import sys
import threading
import time

import numpy as np
import pytest

from orchard_cli.errors import LinkError
from orchard_cli.perception import realsense
from orchard_cli.perception.mount import Mount
from orchard_cli.perception.realsense import RealSense, RealSenseSettings

rs = pytest.importorskip("pyrealsense2", exc_type=ImportError)
WIDTH, HEIGHT, RATE = 848, 480, 30


class Bench:
    """A software device with one depth stream, and a hand to push frames into it."""

    def __init__(self, units: float = 0.001, distortion: float = 0.0) -> None:
        self.device = rs.software_device()
        self.sensor = self.device.add_sensor("Stereo Module")
        lens = rs.intrinsics()
        lens.width, lens.height = WIDTH, HEIGHT
        lens.fx, lens.fy, lens.ppx, lens.ppy = 430.0, 431.0, 420.5, 238.5
        lens.model, lens.coeffs = rs.distortion.brown_conrady, [distortion, 0, 0, 0, 0]
        stream = rs.video_stream()
        stream.type, stream.fmt, stream.index, stream.uid = rs.stream.depth, rs.format.z16, 0, 1
        stream.width, stream.height, stream.fps, stream.bpp = WIDTH, HEIGHT, RATE, 2
        stream.intrinsics = lens
        self.profile = self.sensor.add_video_stream(stream)
        self.sensor.add_read_only_option(rs.option.depth_units, units)
        self.units, self.number = units, 0

    def push(self, depth: np.ndarray, age: float = 0.02, domain: str = "global_time") -> None:
        self.number += 1
        frame = rs.software_video_frame()
        frame.pixels, frame.stride, frame.bpp = depth, 2 * WIDTH, 2
        frame.timestamp, frame.domain = (
            (time.time() - age) * 1e3,
            getattr(rs.timestamp_domain, domain),
        )
        frame.frame_number, frame.depth_units = self.number, self.units
        frame.profile = self.profile.as_video_stream_profile()
        self.sensor.on_video_frame(frame)


def opened(bench: Bench, depth: np.ndarray, **more: object) -> RealSense:
    """Starts the driver while frames come."""
    done = threading.Event()

    def feed() -> None:
        while not done.wait(0.02):
            bench.push(depth, **more)

    feeder = threading.Thread(target=feed)
    feeder.start()
    try:
        return RealSense(
            RealSenseSettings(), Mount(), time.monotonic, device=bench.device, patience=0.5
        )
    finally:
        done.set()
        feeder.join()


def picture(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 7000, (HEIGHT, WIDTH)).astype(np.uint16)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_frames_arrive_bit_for_bit_with_the_cameras_calibration(bench: Bench) -> None:
    depth = picture()
    camera = opened(bench, depth)
    frame = camera.latest()
    assert frame is not None
    np.testing.assert_array_equal(frame.depth_mm, depth)
    model = camera.model
    assert (model.fx, model.fy, model.cx, model.cy) == (430.0, 431.0, 420.5, 238.5)
    assert (model.width, model.height) == (WIDTH, HEIGHT)
    camera.close()


def test_a_frame_is_handed_out_once_and_only_the_newest(bench: Bench) -> None:
    camera = opened(bench, picture())
    for seed in (1, 2):
        bench.push(picture(seed))
        time.sleep(0.1)
    frame = camera.latest()
    assert frame is not None
    np.testing.assert_array_equal(frame.depth_mm, picture(2))
    assert camera.latest() is None
    camera.close()


def test_time_is_that_of_the_exposure_on_the_flight_clock(bench: Bench) -> None:
    camera = opened(bench, picture())
    camera.latest()
    before = time.monotonic()
    bench.push(picture(), age=0.3)
    after = time.monotonic()
    time.sleep(0.1)
    frame = camera.latest()
    assert frame is not None
    assert before - 0.31 < frame.time < after - 0.29
    camera.close()


def test_other_depth_units_become_millimetres() -> None:
    bench = Bench(units=0.0001)
    camera = opened(bench, np.full((HEIGHT, WIDTH), 25_000, np.uint16))
    frame = camera.latest()
    assert frame is not None
    assert frame.depth_mm.min() == frame.depth_mm.max() == 2500
    camera.close()


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ({"domain": "hardware_clock"}, "own clock"),
        ({"age": 5.0}, "old by the computer's clock"),
        ({"age": -5.0}, "old by the computer's clock"),
    ],
)
def test_frames_without_a_known_time_are_not_flown_by(bench: Bench, more: dict, why: str) -> None:
    with pytest.raises(LinkError, match=why):
        opened(bench, picture(), **more)


def test_a_distorted_image_is_refused() -> None:
    with pytest.raises(LinkError, match="rectified"):
        opened(Bench(distortion=0.1), picture())


def test_a_mode_that_the_camera_lacks_is_told_with_those_it_has(bench: Bench) -> None:
    settings = RealSenseSettings(width=640, height=480)
    with pytest.raises(LinkError, match="it has 848x480 at 30 Hz"):
        RealSense(settings, Mount(), time.monotonic, device=bench.device)


@pytest.mark.parametrize("spatial", [False, True])
def test_the_vendors_filters_keep_size_and_fill_holes(spatial: bool) -> None:
    depth = np.full((HEIGHT, WIDTH), 2000, np.uint16)
    depth[100:104, 200:204] = 0
    bench = Bench()
    bench.sensor.add_read_only_option(rs.option.stereo_baseline, 95.0)
    settings = RealSenseSettings(spatial=spatial, fill_holes=True)
    timer = threading.Timer(0.2, bench.push, (depth,))
    timer.start()
    camera = RealSense(settings, Mount(), time.monotonic, device=bench.device)
    frame = camera.latest()
    assert frame is not None
    assert frame.depth_mm.shape == depth.shape
    assert frame.depth_mm[102, 202] == pytest.approx(2000, abs=2)
    camera.close()


def test_a_tilted_mount_looks_down_for_a_positive_pitch() -> None:
    axis = Mount(pitch_down=np.radians(30.0)).body_from_camera @ [0.0, 0.0, 1.0]
    np.testing.assert_allclose(axis, [np.cos(np.pi / 6), 0.0, -0.5], atol=1e-12)


def test_without_the_vendors_library_the_mend_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    with pytest.raises(LinkError, match=r"orchard-cli\[realsense\]"):
        realsense.find()
