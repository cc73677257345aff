"""The eyes of a logged flight, behind the camera socket."""

from __future__ import annotations

import math

import numpy as np
import pytest
import zstandard
from typer.testing import CliRunner

from orchard_cli import mission as missions
from orchard_cli.commands.app import app
from orchard_cli.commands.fly import fly_mission
from orchard_cli.commands.wiring import Choices
from orchard_cli.errors import InputError
from orchard_cli.flightlog import read
from orchard_cli.flightlog.logged_camera import AGAIN, BESIDE, Album, LoggedCamera, album
from orchard_cli.geometry.rotations import from_yaw_pitch_roll
from orchard_cli.model.depth import d455
from orchard_cli.model.mission import Provenance
from orchard_cli.model.vehicle import Pose
from orchard_cli.survey import parse

AHEAD = from_yaw_pitch_roll(0.0)
CAMERA = d455(212, 120)
SURVEY = b"""
[site]
latitude_deg = 23.45
longitude_deg = 113.2
height_m = 20.0
heading_deg = 90.0
[flight]
height_m = 3.5
[[row]]
gaps_m = [3.0, 3.0, 3.0]
tree_height_m = 2.0
"""
WORLD = 'trees = "survey"\n[[pole]]\nx_m = 5.0\ny_m = 0.2\nradius_m = 0.15\nheight_m = 6.0\n'


def made_album(count=10, apart=0.5):
    """Images `apart` m along x; every pixel of image k is 1000 + k mm."""
    pack = zstandard.ZstdCompressor(level=1).compress
    images = [
        pack(np.full((CAMERA.height, CAMERA.width), 1000 + k, "<u2").tobytes())
        for k in range(count)
    ]
    places = np.column_stack([apart * np.arange(count), np.zeros((count, 2))])
    return Album(CAMERA, images, places, np.tile(AHEAD, (count, 1)))


class Flown:
    """Poses along x at a speed, told as they come."""

    def __init__(self, speed, aside=0.0, yaw=0.0):
        self.speed, self.now = speed, 0.0
        self.aside, self.turn = aside, from_yaw_pitch_roll(yaw)

    def poses(self, since):
        steps = np.arange(0, 500) * 0.02
        return tuple(
            Pose(t, np.array([self.speed * t, self.aside, 0.0]), self.turn)
            for t in steps
            if since < t <= self.now
        )

    def seen(self, until):
        """(time asked, frame) of each frame of a flight that lasts `until` s."""
        camera, frames = LoggedCamera(made_album(), self.poses), []
        while self.now < until:
            frame = camera.latest()
            if frame is not None:
                frames.append((self.now, frame))
            self.now += 0.02
        return frames


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0])
def test_images_are_shown_where_they_were_taken_whatever_the_speed(speed):
    for asked, frame in Flown(speed).seen(4.0 / speed):
        taken = 0.5 * (frame.depth_mm[0, 0] - 1000)
        assert abs(speed * frame.time - taken) <= max(BESIDE, 0.5 * speed * AGAIN)
        assert frame.time <= asked
        assert asked - frame.time < 0.1  # fresh: no frame is late by itself


def test_every_image_is_shown_once_in_its_own_place_when_flown_as_logged():
    frames = [f for _, f in Flown(2.0).seen(2.0)]  # images come oftener than AGAIN
    shown = [int(f.depth_mm[0, 0]) - 1000 for f in frames]
    assert shown == sorted(shown)
    assert [abs(2.0 * f.time - 0.5 * k) < 0.05 for f, k in zip(frames[1:], shown[1:], strict=True)]


def test_one_that_stands_is_shown_the_nearest_again_and_again():
    frames = [f for _, f in Flown(0.0).seen(3.0)]
    assert len(frames) >= 3.0 / AGAIN - 1
    assert np.diff([f.time for f in frames]).max() < 0.5  # else the flight would hold


@pytest.mark.parametrize(("aside", "yaw"), [(BESIDE + 0.1, 0.0), (0.0, math.radians(10))])
def test_where_the_log_never_looked_it_sees_nothing(aside, yaw):
    assert not Flown(1.0, aside, yaw).seen(4.0)


@pytest.fixture(scope="module")
def flights(tmp_path_factory):
    """A flight past a pole, and one without the pole that sees the log of the first."""
    folder = tmp_path_factory.mktemp("eyes")
    told = parse(SURVEY, "row")
    provenance = Provenance("row", "0" * 64, "test", "2026-01-01T00:00:00+00:00")
    mission = missions.plan(told.orchard, told.wishes, provenance)
    world = folder / "pole.world.toml"
    world.write_text(WORLD)
    small = {"camera": (212, 120)}
    first, second = folder / "first.mcap", folder / "second.mcap"
    fly_mission(mission, Choices(**small), first, world, lockstep=True, quiet=True)
    eyes = Choices(logged_camera=first, **small)
    fly_mission(mission, eyes, second, lockstep=True, quiet=True)
    return read(first), read(second), first, mission


@pytest.mark.slow
def test_a_flight_turns_for_what_the_log_has_seen(flights):
    """Nothing stands in its own world; at the pole of the log's it goes round."""
    first, second, *_ = flights
    for log in (first, second):
        beside = np.abs(log.odometry.positions_site[:, 1])
        along = log.odometry.positions_site[:, 0]
        assert beside[(along > 4.0) & (along < 6.0)].max() > 0.5
        assert log.safety[-1].phase == "ended"


@pytest.mark.slow
def test_an_album_holds_every_image_with_its_place(flights):
    _, _, path, _ = flights
    found = album(path)
    assert len(found.images) > 30
    assert found.positions_site[:, 2].max() == pytest.approx(3.5, abs=0.2)
    assert found.depth(0).shape == (120, 212)


@pytest.mark.slow
def test_a_real_vehicle_never_flies_by_old_images(flights, tmp_path):
    _, _, path, mission = flights
    missions.save(mission, tmp_path / "m.json")
    words = ["fly", str(tmp_path / "m.json"), "--lockstep", "--logged-camera", str(path)]
    result = CliRunner().invoke(app, [*words, "--connect", "udpin://0.0.0.0:14540"])
    assert isinstance(result.exception, InputError)
    assert "--logged-camera: is the simulator's" in str(result.exception)


def test_a_log_without_images_is_refused(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        album(tmp_path / "none.mcap")
