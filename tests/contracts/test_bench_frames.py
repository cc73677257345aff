"""Depth frames come back out of a log as they went in, each with its pose."""

from __future__ import annotations

import made_flights as made
import numpy as np
import pytest

from orchard_cli.commands.benchmarks.frames import recorded
from orchard_cli.errors import InputError
from orchard_cli.flightlog import McapRecorder
from orchard_cli.flightlog.frames import depth_frames
from orchard_cli.model.depth import DepthFrame, d455

START = 101.0  # s: a second after the made-up flight begins


def written(path, records):
    recorder = McapRecorder(path, patient=True)
    for one in records:
        recorder.write(one)
    recorder.close()
    assert recorder.losses == {}
    return path


@pytest.fixture
def frames():
    random = np.random.default_rng(4)
    images = random.integers(1, 6000, (3, 120, 212)).astype(np.uint16)
    return [DepthFrame(START + 0.5 * k, image, d455(212, 120)) for k, image in enumerate(images)]


@pytest.fixture
def log(frames, tmp_path):
    flown = list(made.flight(made.mission()))
    head, states = flown[0], flown[1:]
    return written(tmp_path / "log.mcap", [head, *frames, *states])


def test_every_frame_of_a_log_comes_back_bit_by_bit_on_the_flight_clock(log, frames):
    found = list(depth_frames(log))
    assert len(found) == len(frames)
    for ours, theirs in zip(found, frames, strict=True):
        assert ours.time == pytest.approx(theirs.time, abs=1e-6)
        assert np.array_equal(ours.depth_mm, theirs.depth_mm)
        camera = theirs.camera
        assert (ours.camera.width, ours.camera.height) == (camera.width, camera.height)
        assert (ours.camera.fx, ours.camera.cx, ours.camera.cy) == pytest.approx(
            (camera.fx, camera.cx, camera.cy)
        )


def test_a_recorded_frame_stands_where_the_vehicle_was_at_its_time(log, frames):
    (stretch,) = recorded(log)
    assert len(stretch.seen) == len(frames)
    for seen in stretch.seen:
        there = made.along(made.corners(), np.array([(seen.frame.time - 100.0) * made.SPEED]))[0]
        assert np.allclose(seen.vehicle.position_site, there, atol=0.3)
        assert seen.vehicle.time == seen.frame.time


def test_a_log_without_frames_is_an_input_error(tmp_path):
    log = written(tmp_path / "blind.mcap", made.flight(made.mission()))
    with pytest.raises(InputError, match="no depth frames"):
        recorded(log)
