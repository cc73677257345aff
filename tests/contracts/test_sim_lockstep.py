"""The lockstep simulator fits the flight's sockets, and repeats itself bit by bit."""

from __future__ import annotations

import hashlib
import math

import numpy as np
import pytest

from orchard_cli.commands.systems import needs_of
from orchard_cli.flight.ports import Camera, Clock, Truth, Vehicle
from orchard_cli.model.site import HeightReference, SiteOrigin
from orchard_cli.model.vehicle import Command, FlightMode, Landed, Pose, Setpoint
from orchard_cli.model.world import Pole, Wind, World
from orchard_cli.perception.radar_camera import RadarCamera
from orchard_cli.simulator import LockstepSimulator, SimulatorSettings

ORIGIN = SiteOrigin(23.68, 112.68, 30.0, HeightReference.AMSL, 0.6)
WORLD = World(
    "field",
    poles=(Pole(6.0, 0.0, 0.1, 5.0),),
    wind=Wind(np.array([1.0, 0.5, 0.0]), gust=0.5),
    seed=11,
)


def simulator(seed: int | None = None) -> LockstepSimulator:
    settings = SimulatorSettings(seed=seed, camera=(212, 120), frame_rate=15.0)
    return LockstepSimulator(WORLD, ORIGIN, (1.0, 2.0), 0.4, settings)


def setpoint(time: float, x: float, y: float, z: float, yaw: float = 0.4) -> Setpoint:
    return Setpoint(time, np.array([x, y, z]), np.zeros(3), np.zeros(3), yaw)


def fly(sim: LockstepSimulator) -> str:
    """Up, forward, down; a digest of everything that was handed out."""
    digest = hashlib.sha256()
    vehicle, clock, camera = sim.vehicle, sim.clock, sim.camera
    assert camera is not None
    clock.sleep_until(3.0)
    vehicle.command(Command.ARM)
    vehicle.command(Command.TAKEOFF, 3.0)
    clock.sleep_until(12.0)
    vehicle.send(setpoint(clock.now(), 1.0, 2.0, 3.0))
    vehicle.command(Command.OFFBOARD)
    while clock.now() < 20.0:
        vehicle.send(setpoint(clock.now(), 3.0, 2.0, 3.0))
        clock.sleep_until(clock.now() + 0.05)
        frame = camera.latest()
        if frame is not None:
            digest.update(frame.depth_mm.tobytes())
    vehicle.command(Command.LAND)
    clock.sleep_until(32.0)
    for record in sim.truth.take():
        digest.update(record.position_site.tobytes() + record.site_from_body.tobytes())
    digest.update(
        repr([(a.command, a.accepted, a.said, a.time) for a in vehicle.answers()]).encode()
    )
    return digest.hexdigest()


def test_it_fits_the_sockets() -> None:
    sim = simulator()
    clock: Clock = sim.clock
    vehicle: Vehicle = sim.vehicle
    truth: Truth = sim.truth
    assert sim.camera is not None
    camera: Camera = sim.camera
    clock.sleep_until(0.5)
    assert clock.now() == pytest.approx(0.5)
    assert vehicle.state() is not None
    assert truth.take()
    assert camera.latest() is not None
    assert camera.latest() is None


def test_the_same_seed_gives_the_same_bits_and_another_one_others() -> None:
    first = fly(simulator())
    assert fly(simulator()) == first
    assert fly(simulator(seed=12)) != first


def test_it_flies_as_it_is_told_and_tells_it_as_mavsdk_would() -> None:
    sim = simulator()
    vehicle, clock = sim.vehicle, sim.clock
    clock.sleep_until(1.0)
    assert not vehicle.state().ready
    vehicle.command(Command.ARM)
    (refused,) = vehicle.answers()
    assert not refused.accepted
    assert "system starting" in refused.said
    clock.sleep_until(3.0)
    assert vehicle.state().ready
    vehicle.command(Command.OFFBOARD)
    assert vehicle.answers()[0].said == "NO_SETPOINT_SET"
    vehicle.command(Command.ARM)
    vehicle.command(Command.TAKEOFF, 3.0)
    assert all(answer.accepted for answer in vehicle.answers())
    clock.sleep_until(3.9)
    assert not vehicle.state().armed  # the heartbeat tells it only once a second
    clock.sleep_until(4.1)
    assert vehicle.state().armed
    clock.sleep_until(12.0)
    vehicle.send(setpoint(12.0, 4.0, 2.0, 3.0, yaw=-0.5))
    vehicle.command(Command.OFFBOARD)
    clock.sleep_until(25.0)
    state = vehicle.state()
    assert state.mode is FlightMode.OFFBOARD
    assert state.landed is Landed.IN_AIR
    assert state.position_site == pytest.approx((4.0, 2.0, 3.0), abs=0.25)
    assert state.yaw_site == pytest.approx(-0.5, abs=0.05)


def test_the_stream_goes_on_by_itself_until_it_is_stopped() -> None:
    """MAVSDK sends the last setpoint again and again, whatever the program does."""
    sim = simulator()
    vehicle, clock = sim.vehicle, sim.clock
    clock.sleep_until(3.0)
    vehicle.command(Command.ARM)
    vehicle.command(Command.TAKEOFF, 3.0)
    clock.sleep_until(12.0)
    vehicle.send(setpoint(12.0, 1.0, 2.0, 3.0))
    vehicle.command(Command.OFFBOARD)
    clock.sleep_until(20.0)
    assert vehicle.state().mode is FlightMode.OFFBOARD
    vehicle.stop_sending()
    clock.sleep_until(22.1)
    assert vehicle.state().mode is FlightMode.RETURN


def test_frames_and_poses_are_stamped_with_the_flight_clock() -> None:
    sim = simulator()
    assert sim.camera is not None
    stamps = []
    for tick in range(200):
        sim.clock.sleep_until((tick + 1) * 0.01)
        frame = sim.camera.latest()
        if frame is not None:
            assert frame.time == sim.clock.now()
            stamps.append(frame.time)
    assert len(stamps) == 30
    assert np.diff(stamps).max() < 0.08
    poses = sim.vehicle.poses(1.0)
    assert [round(pose.time, 3) for pose in poses] == [round(1.02 + 0.02 * k, 3) for k in range(50)]


def test_height_is_counted_from_the_ground_it_stands_on() -> None:
    sim = simulator(seed=3)
    sim.clock.sleep_until(2.0)
    assert sim.vehicle.state().position_site[2] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("wrong", [{"speed_factor": 0.0}, {"speed_factor": math.inf},
                                   {"frame_rate": 0.0}, {"frame_rate": 100.0}])  # fmt: skip
def test_settings_that_cannot_be_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        SimulatorSettings(**wrong)


def test_radar_and_colour_camera_of_one_flight_are_fused_to_what_stands_there():
    """`astar-fused`: what the simulator hands out is enough for radar and camera as one sensor."""
    pytest.importorskip("cv2")
    sensors = needs_of("astar-fused")
    settings = SimulatorSettings(camera=(848, 480), sensors=sensors)
    still = World("column", poles=(Pole(4.0, 0.0, 0.055, 2.1),), seed=3)
    sim, eyes = LockstepSimulator(still, ORIGIN, (0.0, 0.0), 0.0, settings), RadarCamera()
    seen = []
    for now in (2.0, 2.2, 2.4, 2.6):
        sim.clock.sleep_until(now)
        here = sim.truth.take()[-1]
        pose = Pose(now, here.position_site, here.site_from_body)
        seen += eyes.look(sim.sensors.newest(), pose)
    assert seen
    off = [np.hypot(*(one.centre_site - (4.0, 0.0))) for one in seen]
    assert np.median(off) < 0.082 * 4.0  # as the paper's distance
    assert np.median([one.width for one in seen]) < 0.2


def test_a_system_without_colour_gets_none():
    sim = simulator()
    sim.clock.sleep_until(2.0)
    assert sim.sensors.newest().colour is None
