"""Liu 2024, eqs. 1-8: from a pixel and its depth to the world and back."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from orchard_cli.geometry.rotations import from_yaw_pitch_roll
from orchard_cli.mapping.insert import View
from orchard_cli.model.depth import d455
from orchard_cli.model.vehicle import Pose

angle = st.floats(-1.5, 1.5)


@given(st.integers(0, 847), st.integers(0, 479), st.floats(0.6, 6), angle, angle, angle)
def test_the_inverse_projection_undoes_the_papers_projection(u, v, depth, yaw, pitch, roll):
    camera = d455()
    view = View.of(
        camera, Pose(0.0, np.array([12.0, -7.0, 3.5]), from_yaw_pitch_roll(yaw, pitch, roll))
    )
    columns, rows = view.rays(cell=0.1)
    world = view.position_site + 0.1 * 1000 * depth * (columns[:, u] + rows[v]).astype(float)

    k = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]])  # eq. 1
    r = view.site_from_camera.T  # eq. 2: camera from world
    t = -r @ view.position_site
    in_camera = r @ world + t  # eq. 7
    np.testing.assert_allclose(k @ in_camera / in_camera[2], [u, v, 1], atol=2e-3)  # eq. 3
    np.testing.assert_allclose(in_camera[2], depth, atol=1e-5)
    np.testing.assert_allclose(
        in_camera[:2],
        [(u - camera.cx) * depth / camera.fx, (v - camera.cy) * depth / camera.fy],  # eqs. 4, 5
        atol=1e-4,
    )
    np.testing.assert_allclose(
        np.linalg.inv(r) @ (in_camera - t), world, atol=1e-9
    )  # eq. 8, mended


def test_equation_8_as_printed_does_not_undo_equation_7():
    view = View.of(d455(), Pose(0.0, np.array([12.0, -7.0, 3.5]), from_yaw_pitch_roll(0.5)))
    r = view.site_from_camera.T
    t = -r @ view.position_site
    world = np.array([15.0, -6.0, 3.0])
    printed = np.linalg.inv(r) @ (r @ world + t) - t
    assert np.linalg.norm(printed - world) > 1.0
