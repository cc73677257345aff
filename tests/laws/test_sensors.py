"""The simulated radar and lasers, and the way of their scans into the log."""

import multiprocessing

import made_flights as made
import numpy as np
import pytest

from orchard_cli import flightlog
from orchard_cli.flightlog import McapRecorder
from orchard_cli.geometry.rotations import from_yaw_pitch_roll
from orchard_cli.model.sensors import (
    RadarScan,
    RangeScan,
    Sensed,
    corner_lasers,
    plant_protection_radar,
)
from orchard_cli.model.site import HeightReference, SiteOrigin
from orchard_cli.model.world import Box, Person, Pole, SensorNoise, World
from orchard_cli.simulator import LockstepSimulator, SimulatorSettings
from orchard_cli.simulator.board import Board
from orchard_cli.simulator.scene import Scene
from orchard_cli.simulator.sensors import RadarModel, RangeModel

EXACT = SensorNoise(
    dropout=0, radar_range=0, radar_angle=0, radar_speed=0, radar_miss=0, radar_clutter=0,
    laser_range=0,
)  # fmt: skip
RADAR, LASERS = plant_protection_radar(0.0), corner_lasers(0.5)
HERE, LEVEL, STILL = np.array([0.0, 0.0, 3.0]), from_yaw_pitch_roll(0.0), np.zeros(3)


def sweep(world, yaw=0.0, velocity=STILL, number=1, time=0.0):
    model = RadarModel(Scene(world), RADAR)
    return model.scan(HERE, velocity, from_yaw_pitch_roll(yaw), time, number)


@pytest.mark.parametrize(("x", "y"), [(4.0, 0.0), (10.0, 2.0), (20.0, -6.0), (29.0, 0.0)])
def test_a_pole_stands_where_the_radar_says(x, y):
    scan = sweep(World("pole", poles=(Pole(x, y, 0.2, 6.0),), noise=EXACT))
    assert len(scan.returns) >= 1
    off = np.hypot(scan.points_body[:, 0] - x, scan.points_body[:, 1] - y)
    assert (np.abs(off - 0.2) < 0.25).all()  # its surface, within a cell of range
    assert scan.returns[0, 1] == pytest.approx(np.arctan2(y, x), abs=0.03)  # + is to the left


@pytest.mark.parametrize(("x", "y"), [(31.0, 0.0), (10.0, 6.0), (-5.0, 0.0)])
def test_the_radar_sees_thirty_metres_and_fifty_degrees(x, y):
    assert not len(sweep(World("pole", poles=(Pole(x, y, 0.2, 6.0),), noise=EXACT)).returns)


def test_the_radar_does_not_see_what_is_above_or_below_its_beam():
    low = World("low", boxes=(Box(np.array([5.0, 0, 0.5]), np.array([1.0, 1, 1]), 0.0),))
    assert not len(sweep(World("low", boxes=low.boxes, noise=EXACT)).returns)


def test_radial_speed_is_the_way_that_the_range_changes():
    pole = World("pole", poles=(Pole(10.0, 0.0, 0.2, 6.0),), noise=EXACT)
    coming = sweep(pole, velocity=np.array([2.0, 0.0, 0.0]))
    assert coming.returns[:, 3] == pytest.approx(-2.0, abs=0.01)
    person = Person(np.array([8.0, 0.0]), np.array([28.0, 0.0]), 1.5, height=3.2)
    leaving = sweep(World("walk", people=(person,), noise=EXACT), time=1.0)
    assert leaving.returns[:, 3] == pytest.approx(1.5, abs=0.05)


def test_noise_misses_and_clutter_have_the_size_that_the_world_says():
    noise = SensorNoise(radar_clutter=0.5, radar_miss=0.2, radar_range=0.1)
    world = World("pole", poles=(Pole(10.0, 0.0, 0.2, 6.0),), noise=noise)
    scans = [sweep(world, number=n).returns for n in range(300)]
    near = np.array([r for scan in scans for r in scan if abs(r[0] - 9.82) < 0.5])
    exact = len(sweep(World("pole", poles=world.poles, noise=EXACT)).returns)
    ghosts = sum(len(scan) for scan in scans) - len(near)
    assert 0.3 < ghosts / 300 < 0.7
    assert len(near) / (300 * exact) == pytest.approx(0.8, abs=0.06)
    assert near[:, 0].std() == pytest.approx(0.1, abs=0.03)


def test_the_same_number_gives_the_same_scan():
    world = World("pole", poles=(Pole(10.0, 0.0, 0.2, 6.0),), seed=4)
    assert sweep(world).returns.tobytes() == sweep(world).returns.tobytes()
    assert sweep(world).returns.tobytes() != sweep(world, number=2).returns.tobytes()


@pytest.mark.parametrize(
    ("x", "y", "beam", "far"),
    [(3, 0.5, 0, 2.3), (-0.5, 4, 1, 3.3), (3, -0.5, 2, 2.3), (-0.5, -4, 3, 3.3)],
)
def test_each_laser_measures_what_stands_before_it(x, y, beam, far):
    world = World("pole", poles=(Pole(x, y, 0.2, 6.0),), noise=EXACT)
    scan = RangeModel(Scene(world), LASERS).scan(HERE, LEVEL, 0.0, 1)
    expected = np.full(4, np.inf)
    expected[beam] = far
    np.testing.assert_allclose(scan.ranges, expected, atol=1e-5)


def test_a_tilted_laser_measures_the_ground_and_none_reaches_beyond_five_metres():
    empty = RangeModel(Scene(World("empty", noise=EXACT)), LASERS)
    low = np.array([0.0, 0.0, 1.0])
    scan = empty.scan(low, from_yaw_pitch_roll(0.0, pitch=0.3), 0.0, 1)
    expected = (1.0 - 0.5 * np.sin(0.3)) / np.sin(0.3)
    assert scan.ranges[[0, 2]] == pytest.approx(expected, abs=1e-5)
    far = World("pole", poles=(Pole(6.0, 0.5, 0.2, 6.0),), noise=EXACT)
    assert np.isinf(RangeModel(Scene(far), LASERS).scan(HERE, LEVEL, 0.0, 1).ranges).all()


def test_scans_fall_due_ten_times_a_second_and_only_when_asked_for():
    world = World("pole", poles=(Pole(3.0, 0.1, 0.2, 6.0),))
    origin = SiteOrigin(41.0, 9.0, 0.0, HeightReference.AMSL, 0.0)
    asked = SimulatorSettings(camera=None, sensors=frozenset({"radar", "range"}))
    sim = LockstepSimulator(world, origin, (0.0, 0.0), 0.0, asked)
    times = set()
    for tick in range(200):
        sim.clock.sleep_until((tick + 1) * 0.01)
        sensed = sim.sensors.newest()
        times |= {(type(scan), scan.time) for scan in sensed.scans()}
    assert len(times) == 2 * 20
    plain = LockstepSimulator(world, origin, (0.0, 0.0), 0.0, SimulatorSettings(camera=None))
    plain.clock.sleep_until(1.0)
    assert plain.sensors.newest().scans() == ()


def scans():
    rows = np.array([[10.0, 0.1, -0.05, -2.0], [20.0, -0.1, 0.02, np.nan]])
    lasers = RangeScan(1.25, np.array([1.0, np.inf, 2.0, np.inf]), LASERS)
    return RadarScan(1.2, rows, RADAR), lasers


def test_the_board_hands_scans_from_process_to_process():
    board = Board(multiprocessing.get_context("spawn"), None, (RADAR, LASERS))
    assert board.sensed().scans() == ()
    radar, lasers = scans()
    for scan in (radar, lasers, RadarScan(1.3, radar.returns[:1], RADAR)):
        board.put_scan(scan)
    got = board.sensed()
    assert (got.radar.time, got.range.time) == (1.3, 1.25)
    np.testing.assert_array_equal(got.radar.returns, radar.returns[:1])
    np.testing.assert_array_equal(got.range.ranges, lasers.ranges)


def test_scans_come_back_from_the_log(tmp_path):
    radar, lasers = scans()
    recorder = McapRecorder(tmp_path / "f.mcap", patient=True)
    for one in (*made.flight(made.mission()), radar, lasers):
        recorder.write(one)
    recorder.close()
    assert recorder.losses == {}
    log = flightlog.read(tmp_path / "f.mcap")
    (back,), (beams,) = log.radar, log.ranges
    np.testing.assert_array_equal(back.returns, radar.returns)
    np.testing.assert_array_equal(back.points_body, radar.points_body)
    np.testing.assert_array_equal(beams.ranges, lasers.ranges)
    assert beams.beams.names == ("S1", "S2", "S3", "S4")


def test_a_newer_scan_takes_the_place_of_its_kind():
    radar, lasers = scans()
    assert Sensed().after(radar).after(lasers).scans() == (radar, lasers)
