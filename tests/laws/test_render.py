"""What the simulated camera sees is what stands there, with a stereo pair's errors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from orchard_cli.geometry.clearance import clearance
from orchard_cli.geometry.rotations import from_yaw_pitch_roll
from orchard_cli.model.depth import FORWARD, DepthCamera, d455
from orchard_cli.model.world import Box, Person, Pole, SensorNoise, Tree, Wire, World
from orchard_cli.simulator.render import _kernels
from orchard_cli.simulator.render.stereo import BASELINE, stereo_image
from orchard_cli.simulator.scene import Scene

LEVEL = from_yaw_pitch_roll(0.0)
CAMERA = DepthCamera(
    48, 32, 28.0, 28.0, 23.5, 15.5, 0.6, 6.0, FORWARD, np.array([0.1, 0.02, -0.05])
)
CROWD = World(
    "one of each",
    trees=(Tree(3.0, 0.0), Tree(6.0, 2.5, height=3.5, canopy_height=1.5, trunk_radius=0.2)),
    poles=(Pole(4.0, -2.0, 0.15, 3.0), Pole(1.0, 2.0, 0.4, 1.5), Pole(2.5, -3.5, 0.4, 0.7, 2.0)),
    wires=(Wire(np.array([0.0, -4, 3]), np.array([6.0, 4, 4]), 0.5, 0.06),),
    boxes=(Box(np.array([5.0, -1.0, 2.0]), np.array([1.0, 2, 1.5]), 0.7),),
    people=(Person(np.array([2.0, -1]), np.array([2.0, -3]), 1.0),),
)
PERFECT = SensorNoise(disparity_px=0.0, dropout=0.0)


def rays(camera, site_from_body):
    """Site-frame vectors of one metre of depth (h, w, 3), worked out without the renderer."""
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    body = np.stack(
        [np.ones(u.shape), -(u - camera.cx) / camera.fx, -(v - camera.cy) / camera.fy], axis=-1
    )
    w, x, y, z = site_from_body
    return Rotation.from_quat([x, y, z, w]).apply(body.reshape(-1, 3)).reshape(body.shape)


def lens(camera, position, site_from_body):
    w, x, y, z = site_from_body
    return np.asarray(position) + Rotation.from_quat([x, y, z, w]).apply(
        np.array(camera.position_body)
    )


def depths(scene, camera, position, site_from_body, time):
    """True depth (h, w) m, infinite for the sky."""
    with np.errstate(divide="ignore"):
        return 1 / scene.nearness(camera, position, site_from_body, time)


poses = {
    "x": st.floats(-3, 8), "y": st.floats(-5, 5), "z": st.floats(0.3, 6),
    "yaw": st.floats(-3.1, 3.1), "pitch": st.floats(-0.9, 0.9), "roll": st.floats(-0.9, 0.9),
    "time": st.floats(0, 10),
}  # fmt: skip


@settings(max_examples=20, deadline=None)
@given(**poses)
def test_every_return_lies_on_a_surface_and_nothing_stands_before_it(
    x, y, z, yaw, pitch, roll, time
):
    turn = from_yaw_pitch_roll(yaw, pitch, roll)
    eye = lens(CAMERA, (x, y, z), turn)
    if clearance(CROWD, eye[None], np.array([time])).nearest[0] < 0.05 or eye[2] < 0.05:
        return  # the lens is inside something
    depth = depths(Scene(CROWD), CAMERA, np.array([x, y, z]), turn, time)
    along = rays(CAMERA, turn)

    def signed(points):
        flat = points.reshape(-1, 3)
        near = clearance(CROWD, flat, np.full(len(flat), time))
        return near.obstacles, near.trees, flat[:, 2]

    seen = np.isfinite(depth) & (depth < 20)
    obstacles, trees, ground = signed(eye + depth[seen][:, None] * along[seen])
    on = np.minimum(np.abs(obstacles), np.abs(ground))
    gap = _kernels.LEAF_DEPTH * np.linalg.norm(along, axis=2).max()  # canopies are rough inwards
    leaves = (trees < 1e-3) & (trees > -gap)
    assert np.all((on < 2e-3) | leaves)
    for share in np.linspace(0.02, 0.98, 15):
        reach = np.where(np.isfinite(depth), depth, 15.0)
        obstacles, trees, ground = signed(eye + (share * reach)[..., None] * along)
        before = (share * reach).ravel() > 2 * _kernels.NEAR
        assert obstacles[before].min(initial=np.inf) > -2e-3
        assert ground[before].min(initial=np.inf) > -2e-3
        assert trees[before].min(initial=np.inf) > -gap


def test_what_stands_to_the_left_appears_to_the_left():
    scene = Scene(World("left", poles=(Pole(5.0, 1.0, 0.2, 9.0),), noise=PERFECT))
    image = scene.render(d455(), np.array([0.0, 0.0, 3.0]), LEVEL, 0.0, 1)
    columns = np.flatnonzero(image[100] > 0)
    assert columns.max() < 424
    # the pole's middle: u = cx - fx * y / depth
    camera = d455()
    assert columns.mean() == pytest.approx(camera.cx - camera.fx * 1.0 / 4.9, abs=3)


def test_a_raised_nose_sees_less_ground_and_the_sky_returns_nothing():
    scene = Scene(World("plain", noise=PERFECT))
    returns = [
        np.count_nonzero(
            scene.render(CAMERA, np.array([0.0, 0, 2]), from_yaw_pitch_roll(0, pitch), 0.0, 0)
        )
        for pitch in (-0.2, 0.0, 0.2)  # positive pitch lowers the nose
    ]
    assert returns[0] < returns[1] < returns[2]
    level = scene.render(CAMERA, np.array([0.0, 0, 2]), LEVEL, 0.0, 0)
    assert not level[:16].any()


def test_a_level_ray_never_meets_the_ground():
    camera = DepthCamera(9, 9, 8.0, 8.0, 4.0, 4.0, 0.6, 6.0, FORWARD, np.zeros(3))
    scene = Scene(World("plain", poles=(Pole(30.0, 0.0, 0.2, 9.0),)))
    depth = depths(scene, camera, np.array([0.0, 0.0, 2.0]), LEVEL, 0.0)
    assert np.isinf(depth[:5, :4]).all()
    np.testing.assert_allclose(depth[5:, 0], 2.0 * 8.0 / np.arange(1, 5), rtol=1e-6)


def test_the_ground_follows_the_feet_of_the_trees():
    trees = tuple(Tree(x, y, ground=0.1 * x - 0.05 * y) for x in (0.0, 10.0) for y in (0.0, 8.0))
    scene = Scene(World("slope", trees=trees))
    assert scene.ground_height(5.0, 4.0) == pytest.approx(0.3)
    assert Scene(World("level", trees=(Tree(1.0, 2.0),))).ground_height(9.0, 9.0) == 0.0


def test_the_same_seed_and_frame_give_the_same_bits_and_another_frame_does_not():
    scene = Scene(CROWD)
    first, again, other = (
        scene.render(d455(212, 120), np.array([0.0, 0, 2]), LEVEL, 0.0, n) for n in (4, 4, 5)
    )
    np.testing.assert_array_equal(first, again)
    assert np.count_nonzero(first != other) > 1000


def flat(distance, sigma=0.1, dropout=0.0, number=1, camera=None):
    camera = camera or d455()
    depth = np.full((camera.height, camera.width), distance, dtype=np.float32)
    return stereo_image(1 / depth, camera, sigma, dropout, 3, number)[:, 5:] / 1000.0


@pytest.mark.parametrize("distance", [1.0, 2.0, 4.0, 6.0])
def test_the_depth_error_grows_with_the_square_of_the_distance(distance):
    error = flat(distance) - distance
    quantum = 1 / 32 / np.sqrt(12)  # px
    want = distance**2 / (d455().fx * BASELINE) * np.hypot(0.1, quantum)
    assert error.std() == pytest.approx(want, rel=0.1)
    assert abs(error.mean()) < 0.2 * want + 0.002


def test_half_of_the_error_is_shared_by_blocks_of_pixels_and_none_by_strangers():
    error = flat(4.0)[:, 3:839] - 4.0  # columns from 8 on: whole blocks
    error -= error.mean()
    blocks = error.reshape(120, 4, 209, 4).mean(axis=(1, 3))
    assert blocks.std() / error.std() == pytest.approx(np.sqrt(0.5 + 0.5 / 16), abs=0.03)
    assert abs((blocks[:, :-1] * blocks[:, 1:]).mean()) < 0.05 * blocks.var()
    assert abs((blocks[:-1] * blocks[1:]).mean()) < 0.05 * blocks.var()


def test_disparity_comes_in_steps_of_a_thirty_second_of_a_pixel():
    fields = d455().fx * BASELINE / flat(2.0)
    off = fields * 32 - np.round(fields * 32)
    assert np.abs(off).max() < 0.2  # a millimetre of rounding


def test_the_asked_share_of_pixels_drops_out():
    assert np.mean(flat(3.0, dropout=0.05) == 0) == pytest.approx(0.05, rel=0.05)
    assert np.all(flat(3.0, dropout=0.0) > 0)


@pytest.mark.parametrize("distance", [0.3, 0.55, 21.0, np.inf])
def test_out_of_range_returns_nothing(distance):
    assert not flat(distance, sigma=0.0).any()


def test_what_is_hidden_from_the_other_imager_is_a_hole_on_the_left():
    camera = d455()
    depth = np.full((camera.height, camera.width), 10.0, dtype=np.float32)
    depth[:, 400:450] = 2.0
    image = stereo_image(1 / depth, camera, 0.0, 0.0, 0, 0)
    holes = (image == 0).mean(axis=0)
    shadow = camera.fx * BASELINE * (1 / 2.0 - 1 / 10.0)  # px
    assert holes[400 - int(shadow) + 1 : 399].min() == 1.0
    assert holes[5 : 400 - int(shadow) - 2].max() == 0.0
    assert holes[400:].max() == 0.0


def test_some_pixels_at_an_edge_fly_between_its_two_sides():
    camera = d455()
    depth = np.full((camera.height, camera.width), 10.0, dtype=np.float32)
    depth[:, 400:450] = 2.0
    image = stereo_image(1 / depth, camera, 0.0, 0.0, 0, 0)
    flying = (image > 2100) & (image < 9500)
    assert set(np.flatnonzero(flying.any(axis=0))) == {399, 449}
    assert flying[:, 449].mean() == pytest.approx(_kernels.FLYING, abs=0.06)


def test_the_drawing_kernels_do_what_their_python_says(monkeypatch):
    place, turn = np.array([0.0, 0.3, 2.2]), from_yaw_pitch_roll(0.1, 0.2, 0.05)
    compiled = Scene(CROWD).nearness(CAMERA, place, turn, 1.0)
    image = stereo_image(compiled, CAMERA, 0.1, 0.01, 3, 9)
    for name, kernel in list(vars(_kernels).items()):
        if hasattr(kernel, "py_func"):
            monkeypatch.setattr(_kernels, name, kernel.py_func)
    with np.errstate(all="ignore"):
        interpreted = Scene(CROWD).nearness(CAMERA, place, turn, 1.0)
        again = stereo_image(compiled, CAMERA, 0.1, 0.01, 3, 9)
    np.testing.assert_allclose(interpreted, compiled, rtol=1e-5)
    assert np.abs(again.astype(int) - image).max() <= 1
