"""What is injected into a running simulation happens, lasts as long as asked, and ends."""

import numpy as np
import pytest

from orchard_cli.model.world import Pole, World
from orchard_cli.simulator import LockstepSimulator, SimulatorSettings
from orchard_cli.simulator.faults import (
    BatteryDrop,
    CameraFault,
    ClockStep,
    Failure,
    GpsLoss,
    OriginMove,
    WindChange,
)
from orchard_cli.simulator.mavlink import Endpoint
from tests.contracts.test_sim_lockstep import ORIGIN

WORLD = World("field", poles=(Pole(3.0, 0.0, 0.3, 5.0),), seed=3)


@pytest.fixture
def running():
    settings = SimulatorSettings(camera=(212, 120), frame_rate=20.0)
    simulator = LockstepSimulator(WORLD, ORIGIN, (0.0, 0.0), 0.0, settings)
    simulator.clock.sleep_until(0.5)
    simulator.camera.latest()
    return simulator


def frames(simulator, seconds):
    taken, end = [], simulator.time + seconds
    while simulator.time < end - 1e-9:
        simulator.step()
        frame = simulator.camera.latest()
        if frame is not None:
            taken.append(frame)
    return taken


def test_a_well_camera_never_repeats_an_image(running):
    seen = frames(running, 0.5)
    assert len({frame.depth_mm.tobytes() for frame in seen}) == len(seen) == 10


def test_a_frozen_camera_repeats_the_last_good_image_with_fresh_stamps_and_thaws(running):
    last = frames(running, 0.1)[-1]
    running.inject(CameraFault(Failure.FROZEN, 0.5))
    seen = frames(running, 0.5)
    assert all(np.array_equal(frame.depth_mm, last.depth_mm) for frame in seen[:-1])
    assert all(a.time < b.time for a, b in zip([last, *seen], seen, strict=False))
    assert not np.array_equal(frames(running, 0.1)[-1].depth_mm, last.depth_mm)


def test_a_blank_a_garbled_and_a_silent_camera(running):
    running.inject(CameraFault(Failure.BLANK))
    assert not any(frame.depth_mm.any() for frame in frames(running, 0.3))
    running.inject(CameraFault(Failure.GARBAGE))
    garbled = frames(running, 0.3)
    assert all(frame.depth_mm.std() > 15_000 for frame in garbled)
    running.inject(CameraFault(Failure.SILENT, 0.3))
    assert frames(running, 0.29) == []
    running.inject(CameraFault(Failure.NONE))
    assert frames(running, 0.1)[0].depth_mm.std() < 15_000


def test_a_lost_fix_is_told_and_comes_back(running):
    running.clock.sleep_until(3.0)
    assert running.vehicle.state().ready
    running.inject(GpsLoss(2.0))
    running.clock.sleep_until(4.9)
    assert "GPS fix too low" in running.vehicle.state().not_ready
    running.clock.sleep_until(10.0)
    assert running.vehicle.state().ready


def test_the_wind_changes_and_the_battery_drops(running):
    running.inject(BatteryDrop(0.3))
    running.inject(WindChange((4.0, -1.0, 0.0)))
    running.step()
    running.step()
    assert running.vehicle.state().battery_share <= 0.3
    assert running._run.autopilot.craft.body.around[:2] == pytest.approx([4.0, -1.0], abs=2.0)


def test_what_is_mavlinks_alone_is_refused_in_lockstep(running):
    for fault in (ClockStep(5.0), OriginMove((1.0, 0.0, 0.0))):
        with pytest.raises(ValueError, match="MAVLink"):
            running.inject(fault)


def test_a_clock_that_steps_shows_in_every_stamp(running):
    endpoint = Endpoint(running._run.autopilot, ORIGIN, 0.0)
    before = endpoint._scope().told.boot_us
    endpoint.inject(ClockStep(3.5))
    assert endpoint._scope().told.boot_us - before == 3_500_000
