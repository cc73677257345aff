"""Logs of PX4 and ROS 2 give the metrics that their data allow; the rest says why not."""

from __future__ import annotations

import json
import lzma
import random
from dataclasses import replace
from pathlib import Path

import made_flights as made
import numpy as np
import pytest
from typer.testing import CliRunner

from orchard_cli.commands.app import app
from orchard_cli.errors import InputError
from orchard_cli.flightlog.foreign.kinds import Kind, kind_of
from orchard_cli.flightlog.foreign.ros import read_ros
from orchard_cli.flightlog.foreign.ulog import read_ulog
from orchard_cli.mission import dumps, plan
from orchard_cli.model.site import HeightReference, SiteOrigin, TreeRow
from orchard_cli.model.wishes import FlightWishes

ULOG = Path(__file__).parents[1] / "data" / "px4_pi_20x6.ulg.xz"
PX4_HOME = SiteOrigin(46.2276002, 11.1296998, 250.017, HeightReference.AMSL, 0.0)
SCHEMA = """std_msgs/Header header
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/PoseWithCovariance
geometry_msgs/Pose pose
float64[36] covariance
================================================================================
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
================================================================================
MSG: geometry_msgs/TwistWithCovariance
geometry_msgs/Twist twist
float64[36] covariance
================================================================================
MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""


def analyze(*words):
    return CliRunner().invoke(app, ["analyze", *map(str, words)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("foreign")


@pytest.fixture(scope="module")
def ulog(folder):
    path = folder / "flight.ulg"
    path.write_bytes(lzma.decompress(ULOG.read_bytes()))
    return path


@pytest.fixture(scope="module")
def recorded_mission():
    """What the recorded flight was to fly: 20 m north, 6 m east, 20 m south, at 3.5 m."""
    trees = np.arange(0.0, 21.0, 4.0)
    rows = tuple(
        TreeRow(np.column_stack([trees, np.full(6, y)]), np.zeros(6), np.full(6, 2.6))
        for y in (0.0, -6.0)
    )
    made_up = made.mission()
    orchard = replace(made_up.orchard, origin=PX4_HOME, rows=rows, obstacles=())
    return plan(orchard, FlightWishes(height=3.5), made_up.provenance)


def test_a_px4_flight_gives_the_metrics_that_its_data_allow(ulog, recorded_mission, folder):
    mission = folder / "px4.mission.json"
    mission.write_text(dumps(recorded_mission))
    result = analyze(ulog, "--mission", mission, "--json")
    assert result.exit_code == 0, result.exception
    (entry,) = json.loads(result.stdout)["logs"]
    figures = entry["metrics"]
    assert figures["distance_m"] == pytest.approx(46.0, abs=2.5)  # it overshoots both corners
    assert figures["deviation_max_m"] < 1.2  # FACTS of PX4's own simulator: up to 1.1 m
    assert figures["height_error_max_m"] < 0.6
    assert figures["speed_max_m_s"] == pytest.approx(1.3, abs=0.4)
    assert 0 < figures["yaw_rate_max_rad_s"] < 3.0
    assert figures["battery_left_percent"] > 50
    for name in ("clearance_min_m", "coverage_percent", "replans"):
        assert figures[name] is None
        assert entry["unknown"][name]


def test_a_foreign_log_without_a_mission_says_what_it_needs(ulog):
    assert "--mission" in str(analyze(ulog).exception)


def bag(path, heading=None, cut=1.0):
    """A ROS 2 bag of the made-up flight, written by mcap-ros2-support itself."""
    from mcap_ros2.writer import Writer

    from orchard_cli.geometry.frames import enu_from_site

    turn = np.eye(3) if heading is None else enu_from_site(heading)
    plan_ = made.planned_mission()
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=20_000)
        schema = writer.register_msgdef("nav_msgs/msg/Odometry", SCHEMA)
        for one in made.flight(plan_, made.Bump(10.0, 8.0, 1.5), as_planned=True):
            if type(one).__name__ != "VehicleState":
                continue
            w, x, y, z = (float(v) for v in one.site_from_body)
            yaw = 2 * np.arctan2(z, w)
            x, y, z = (float(v) for v in turn @ one.position_site)
            c, s = np.cos(yaw), np.sin(yaw)
            ahead = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ one.velocity_site
            seen = yaw if heading is None else yaw + np.pi / 2 - heading
            message = {
                "header": {"stamp": {"sec": int(one.time), "nanosec": int(one.time % 1 * 1e9)},
                           "frame_id": "map"},
                "child_frame_id": "base_link",
                "pose": {"pose": {"position": {"x": x, "y": y, "z": z},
                                  "orientation": {"x": 0.0, "y": 0.0, "z": float(np.sin(seen / 2)),
                                                  "w": float(np.cos(seen / 2))}},
                         "covariance": [0.0] * 36},
                "twist": {"twist": {"linear": dict(zip("xyz", map(float, ahead), strict=True)),
                                    "angular": {"x": 0.0, "y": 0.0,
                                                "z": float(one.angular_velocity_body[2])}},
                          "covariance": [0.0] * 36},
            }  # fmt: skip
            writer.write_message("/odom", schema, message, int(one.time * 1e9))
        writer.finish()
    return path


@pytest.mark.parametrize("heading", [None, 0.3])
def test_a_ros_bag_gives_the_same_metrics_as_our_own_log(folder, heading):
    path = bag(folder / f"odom-{heading}.mcap", heading)
    mission = folder / "made.mission.json"
    mission.write_text(dumps(made.planned_mission()))
    frame = "site" if heading is None else "enu"
    result = analyze(path, "--mission", mission, "--frame", frame, "--json")
    assert result.exit_code == 0, result.exception
    (entry,) = json.loads(result.stdout)["logs"]
    assert entry["metrics"]["deviation_max_m"] == pytest.approx(1.5, abs=0.05)
    assert entry["metrics"]["speed_max_m_s"] == pytest.approx(1.15, abs=0.2)
    assert entry["metrics"]["distance_m"] == pytest.approx(47.0, abs=2.0)
    assert entry["metrics"]["battery_left_percent"] is None
    assert len(entry["avoidances"]) == 1


def test_a_topic_is_asked_for_by_name(folder):
    path = bag(folder / "named.mcap")
    assert len(read_ros(path, "/odom", None).odometry.times) > 100
    with pytest.raises(InputError, match=r"no odometry or pose topic /pose; it has: /odom"):
        read_ros(path, "/pose", None)


def test_logs_are_told_apart_by_what_they_hold(ulog, folder):
    assert kind_of(ulog) is Kind.ULOG
    assert kind_of(bag(folder / "kind.mcap")) is Kind.ROS2
    assert kind_of(folder / "missing.mcap") is Kind.OURS


def test_a_cut_bag_is_read_up_to_the_cut_and_says_so(folder):
    whole = bag(folder / "whole.mcap")
    cut = folder / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    found = read_ros(cut, None, None)
    assert 0 < len(found.odometry.times) < len(read_ros(whole, None, None).odometry.times)
    assert any("cut off" in note for note in found.notes)


@pytest.mark.parametrize("seed", range(6))
def test_a_damaged_ulog_is_measured_or_refused_in_one_line(ulog, recorded_mission, folder, seed):
    chance = random.Random(seed)
    data = bytearray(ulog.read_bytes())
    for _ in range(30):
        data[chance.randrange(16, len(data) if seed % 2 else 4000)] = chance.randrange(256)
    path = folder / f"damaged{seed}.ulg"
    path.write_bytes(data[: chance.randrange(len(data) // 2, len(data))])
    said = "measured"
    try:
        read_ulog(path, recorded_mission)
    except InputError as error:
        said = str(error)
    assert "\n" not in said
