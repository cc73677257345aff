"""Radar-camera fusion: each reflection in its pixel, each image with its scan, sizes of columns."""

import numpy as np
import pytest

from orchard_cli.geometry.rotations import from_yaw_pitch_roll
from orchard_cli.model.depth import d455
from orchard_cli.model.sensors import ColourFrame, RadarScan, plant_protection_radar
from orchard_cli.model.vehicle import Pose
from orchard_cli.model.world import Pole, World
from orchard_cli.perception.radar_camera import RadarCameraSettings
from orchard_cli.perception.radar_camera.contour import grey
from orchard_cli.perception.radar_camera.sensor import measure
from orchard_cli.perception.radar_camera.spatial import pixels
from orchard_cli.perception.radar_camera.timing import Pair, pair
from orchard_cli.simulator.colour import colour_image
from orchard_cli.simulator.scene import Scene
from orchard_cli.simulator.sensors import RadarModel

CAMERA, RADAR, LEVEL = d455(848, 480), plant_protection_radar(0.0), from_yaw_pitch_roll(0.0)
BLANK = np.zeros((2, 2, 3), dtype=np.uint8)


def scan(time=0.0, *returns):
    return RadarScan(time, np.array(returns, dtype=float).reshape(-1, 4), RADAR)


def test_a_reflection_lies_in_the_pixel_that_sees_its_place():
    """Eq. 3: straight ahead in the middle, left is left, up is up, by the pinhole's own rule."""
    ahead = pixels(scan(0.0, (5.1, 0, 0, 0)), CAMERA)[0]
    np.testing.assert_allclose(ahead, [CAMERA.cx, CAMERA.cy, 5.0], atol=1e-9)
    u, v, depth = pixels(scan(0.0, (5.1, 0.2, 0.1, 0)), CAMERA)[0]
    point = 5.1 * np.array([np.cos(0.1) * np.cos(0.2), np.cos(0.1) * np.sin(0.2), np.sin(0.1)])
    assert depth == pytest.approx(point[0] - 0.1)
    assert u == pytest.approx(CAMERA.cx - CAMERA.fx * point[1] / depth)
    assert v == pytest.approx(CAMERA.cy - CAMERA.fy * point[2] / depth)


def test_what_is_behind_has_no_pixel():
    assert np.isnan(pixels(scan(0.0, (5.0, np.pi, 0, 0)), CAMERA)[0, :2]).all()


def test_each_image_gets_the_scan_nearest_in_time():
    """§2.2.2: 90 Hz to 30 Hz."""
    scans = [scan(k / 90, (2.5, 0, 0, 0)) for k in range(90)]
    images = [ColourFrame(k / 30 + 0.002, BLANK, CAMERA) for k in range(29)]
    found = pair(scans, images, trigger=3.0, apart=1 / 180)
    assert len(found) == len(images)
    assert max(abs(one.scan.time - one.image.time) for one in found) <= 1 / 180
    later = pair(scans, images, 3.0, 1 / 180, since=images[9].time)
    assert [one.image for one in later] == images[10:]


def test_no_image_is_taken_of_what_is_far_or_long_ago():
    image = [ColourFrame(1.0, BLANK, CAMERA)]
    assert pair([scan(1.0, (3.1, 0, 0, 0))], image, 3.0, 0.01) == ()
    assert pair([scan(1.0)], image, 3.0, 0.01) == ()
    assert pair([scan(0.9, (2.0, 0, 0, 0))], image, 3.0, 0.01) == ()
    assert pair([], image, 3.0, 0.01) == ()


def test_grey_weighs_the_colours():
    """Eq. 5."""
    colours = np.array([[[100, 0, 0], [0, 100, 0], [0, 0, 100], [255, 255, 255]]], dtype=np.uint8)
    assert grey(colours).tolist() == [[30, 59, 11, 255]]


@pytest.mark.parametrize("far", [3.0, 4.0, 5.0])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_column_is_measured_within_the_papers_errors(far, seed):
    """Table 4: 8.2 % of distance, 27.3 % of width, 18.5 % of height, of 110 mm x 2100 mm."""
    pytest.importorskip("cv2")
    world = World("column", poles=(Pole(far + 0.055, 0.0, 0.055, 2.1),), seed=seed)
    scene, place = Scene(world), np.array([0.0, 0.0, 1.2])
    sweep = RadarModel(scene, RADAR).scan(place, np.zeros(3), LEVEL, 0.0, 1)
    image = ColourFrame(0.0, colour_image(scene, CAMERA, place, LEVEL, 0.0, 1), CAMERA)
    found = measure(Pair(sweep, image), Pose(0.0, place, LEVEL), RadarCameraSettings())
    assert found is not None
    assert found.distance == pytest.approx(far, rel=0.082)
    assert found.width == pytest.approx(0.110, rel=0.273)
    assert found.height == pytest.approx(2.1, rel=0.185)
    assert np.hypot(*(found.centre_site - [far + 0.055, 0.0])) < 0.3
