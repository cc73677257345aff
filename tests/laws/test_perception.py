"""The detector from depth alone, and what depth makes of boxes, on rendered frames."""

import numpy as np
import pytest

from orchard_cli.geometry.rotations import from_yaw_pitch_roll
from orchard_cli.model.depth import DepthFrame, d455
from orchard_cli.model.obstacles import Category, Detection
from orchard_cli.model.vehicle import Pose
from orchard_cli.model.world import Box, Person, Pole, SensorNoise, Tree, Wire, World
from orchard_cli.perception import DepthDetector, RgbdEyes
from orchard_cli.perception import _kernels as kernels
from orchard_cli.perception.distance import Rule, centre_of_gravity, distance
from orchard_cli.perception.fusion import flat_extent, round_extent
from orchard_cli.simulator.scene import Scene

CAMERA = d455(424, 240)
WORLDS = {
    Category.POLE: World("", poles=(Pole(5.0, 0.3, 0.15, 8.0),)),
    Category.TREE: World("", trees=(Tree(5.5, 0.0, height=3.4, canopy_radius=1.2,
                                         canopy_height=2.4),)),
    Category.BUILDING: World("", boxes=(Box(np.array([7.0, 0, 1.5]), np.array([4.0, 5, 3]), 0.0),)),
    Category.WIRE: World("", wires=(Wire(np.array([4.5, -4, 3.2]), np.array([4.5, 4, 3.2]), 0.2,
                                         0.02),)),
    Category.PERSON: World("", people=(Person(np.array([6.0, 0]), np.array([6.0, 0]), 0.0),)),
}  # fmt: skip


def look(world, height=2.5, yaw=0.0, number=1, pitch=0.0, roll=0.0, place=(0.0, 0.0)):
    position = np.array([*place, height])
    turn = from_yaw_pitch_roll(yaw, pitch, roll)
    depth = Scene(world).render(CAMERA, position, turn, 0.0, number)
    frame, pose = DepthFrame(0.0, depth, CAMERA), Pose(0.0, position, turn)
    return RgbdEyes(DepthDetector()).look(frame, pose, None).obstacles


@pytest.mark.parametrize("category", WORLDS)
@pytest.mark.parametrize("number", [1, 2])
def test_things_are_told_apart_by_size_and_shape(category, number):
    height = 1.6 if category is Category.PERSON else 2.5
    seen = look(WORLDS[category], height=height, number=number)
    assert seen
    assert max(seen, key=lambda one: one.detection.score).category is category


def test_bare_ground_is_nothing():
    assert look(World("")) == ()


@pytest.mark.parametrize(("pitch", "roll"), [(0.0, 0.0), (0.1, 0.0), (0.0, 0.06), (-0.05, -0.06)])
def test_place_and_size_whatever_the_attitude(pitch, roll):
    seen = look(WORLDS[Category.POLE], pitch=pitch, roll=roll, yaw=0.2)
    pole = next(one for one in seen if one.category is Category.POLE)
    np.testing.assert_allclose(pole.centre_site[:2], [5.0, 0.3], atol=0.3)
    assert 0.2 <= pole.width <= 0.4 + 4 * abs(roll)  # a box that is not upright is wider: safe


def test_a_ghost_pixel_is_nothing():
    """PEERS: stereo ghosts: repeating patterns give false near points, flying pixels."""
    noise = SensorNoise(dropout=0.1)
    assert look(World("", noise=noise)) == ()
    depth = np.zeros((240, 424), dtype=np.uint16)
    depth[100:102, 200:202] = 2000
    pose = Pose(0.0, np.array([0.0, 0, 3]), from_yaw_pitch_roll(0.0))
    frame = DepthFrame(0.0, depth, CAMERA)
    assert RgbdEyes(DepthDetector()).look(frame, pose, None).obstacles == ()


BOX = Detection(Category.TREE, 0.9, 100.0, 60.0, 200.0, 160.0)


def image(near=5000, rows=slice(60, 160), columns=slice(100, 200), behind=9000):
    depth = np.full((240, 424), behind, dtype=np.uint16)
    depth[rows, columns] = near
    return depth


def test_depth_is_the_mean_where_both_points_agree():
    found = distance(BOX, image(), 0.6, 20.0)
    assert found.rule is Rule.MEAN
    assert found.depth == pytest.approx(5.0)


def test_depth_is_that_of_the_centre_of_gravity_where_the_box_is_off():
    found = distance(BOX, image(columns=slice(100, 140)), 0.6, 20.0)
    assert found.rule is Rule.GRAVITY
    assert found.depth == pytest.approx(5.0)
    assert found.column == pytest.approx(119.5, abs=1.0)


def test_depth_is_that_of_the_centre_where_there_is_no_object():
    depth = np.zeros((240, 424), dtype=np.uint16)
    depth[109:112, 149] = 5000  # too small for a centre of gravity
    assert distance(BOX, depth, 0.6, 20.0).rule is Rule.CENTRE


def test_depth_is_the_mean_of_the_centreline_where_the_centre_is_void():
    depth = np.zeros((240, 424), dtype=np.uint16)
    depth[110, 104], depth[110, 190] = 4000, 5000
    found = distance(BOX, depth, 0.6, 20.0)
    assert found.rule is Rule.LINE
    assert found.depth == pytest.approx(4.5)
    assert distance(BOX, np.zeros_like(depth), 0.6, 20.0) is None


def test_the_centre_of_gravity_is_that_of_the_largest_near_thing():
    box = np.full((40, 60), 8.0)
    box[10:30, 40:50], box[2:4, 2:4] = 4.0, 4.0
    assert centre_of_gravity(box) == pytest.approx((44.5, 19.5))
    assert centre_of_gravity(np.zeros((10, 10))) is None


def test_equation_2_for_what_is_flat_and_tangents_for_what_is_round():
    half = np.arcsin(1.5 / 6.0)  # of a cylinder of 1.5 m at 6 m
    edge = CAMERA.fx * np.tan(half)
    box = Detection(Category.TREE, 0.9, CAMERA.cx - edge, 60.0, CAMERA.cx + edge, 160.0)
    flat, found = flat_extent(box, 4.5, CAMERA), round_extent(box, 4.5, CAMERA)
    assert found.width == pytest.approx(3.0)
    assert found.depth == pytest.approx(6.0)
    assert flat.width == pytest.approx(2 * 4.5 * np.tan(half))


def test_kernels_are_the_same_in_python():
    rng = np.random.default_rng(3)
    depth = np.where(rng.random((12, 16)) < 0.8, rng.choice([2.0, 2.1, 5.0], (12, 16)), 0.0)
    kept = np.empty_like(depth)
    kernels.drop_lonely.py_func(depth, 0.2, 0.01, 2, kept)
    fast = np.empty_like(depth)
    kernels.drop_lonely(depth, 0.2, 0.01, 2, fast)
    np.testing.assert_array_equal(kept, fast)
    results = []
    for label in (kernels.label, kernels.label.py_func):
        labels, parent = np.empty((12, 16), np.int32), np.empty(192, np.int64)
        results.append((label(kept, 0.2, 0.01, parent, labels), labels))
    assert results[0][0] == results[1][0]
    np.testing.assert_array_equal(results[0][1], results[1][1])
