"""What an autopilot passes on of radar and lasers; a wrong sign here is a crash."""

import math

import numpy as np
import pytest

from orchard_cli.model.sensors import corner_lasers, plant_protection_radar
from orchard_cli.vehicle.rangefinders import laser_range, radar_scan, range_scan

RADAR, LASERS = plant_protection_radar(0.0), corner_lasers(0.5)


def obstacles(**at):
    distances = [65535] * 72
    for name, centimetres in at.items():
        distances[int(name[1:])] = centimetres
    return {
        "frame": 12, "distances": distances, "increment": 5, "increment_f": 0.0,
        "min_distance": 20, "max_distance": 3000, "angle_offset": 0.0,
    }  # fmt: skip


def test_directions_count_clockwise_and_ours_to_the_left():
    scan = radar_scan(obstacles(_0=1000, _3=500, _69=700), RADAR, 1.5)
    found = {round(r, 2): round(math.degrees(a)) for r, a, *_ in scan.returns.tolist()}
    assert found == {10.0: 0, 5.0: -15, 7.0: 15}  # index 3 is 15 degrees to the right
    assert scan.time == 1.5
    assert np.isnan(scan.returns[:, 3]).all()


def test_nothing_unknown_and_behind_give_no_reflection():
    scan = radar_scan(obstacles(_0=3001, _1=65535, _2=10, _36=500), RADAR, 0.0)
    assert len(scan.returns) == 0


def test_finer_steps_and_an_offset_are_kept():
    fields = {**obstacles(_0=1000), "increment_f": 1.0, "angle_offset": 10.0}
    (row,) = radar_scan(fields, RADAR, 0.0).returns.tolist()
    assert math.degrees(row[1]) == pytest.approx(-10.0)


def test_north_aligned_distances_are_not_taken_for_the_bodys():
    assert radar_scan({**obstacles(_0=1000), "frame": 0}, RADAR, 0.0) is None


def laser(number, orientation, centimetres=200, **more):
    return {
        "id": number, "orientation": orientation, "current_distance": centimetres,
        "max_distance": 500, **more,
    }  # fmt: skip


def test_a_laser_must_point_where_its_number_says():
    assert laser_range(laser(1, 0)) == (1, 2.0)
    assert laser_range(laser(2, 6)) == (2, 2.0)  # MAVLink's 270 degrees: left
    assert laser_range(laser(4, 2)) == (4, 2.0)  # 90 degrees: right
    assert laser_range(laser(2, 2)) is None
    assert laser_range(laser(0, 25)) is None  # looks down: another sensor
    assert laser_range(laser(3, 0, 500)) == (3, math.inf)
    assert laser_range(laser(3, 0, signal_quality=1)) is None


def test_four_lasers_make_a_scan_and_three_do_not():
    heard = {n: (10.0 + n / 100, float(n)) for n in (1, 2, 3)}
    assert range_scan(heard, LASERS) is None
    scan = range_scan({**heard, 4: (10.2, 4.0)}, LASERS)
    assert (scan.time, scan.ranges.tolist()) == (10.01, [1.0, 2.0, 3.0, 4.0])
    assert range_scan({**heard, 4: (10.4, 4.0)}, LASERS) is None
