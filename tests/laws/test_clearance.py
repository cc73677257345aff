"""Clearance is the distance to the nearest surface, and negative inside."""

import numpy as np
import pytest

from orchard_cli.geometry import clearance as module
from orchard_cli.geometry.clearance import clearance
from orchard_cli.geometry.shapes import walker_at, wire_capsules
from orchard_cli.model.world import Box, Person, Pole, Tree, Wire, World

POLE = World("pole", poles=(Pole(5.0, 2.0, 0.15, 6.0),))


def at(world, *points, times=None):
    return clearance(world, np.array(points, dtype=float), times)


def test_a_pole_is_measured_to_its_side_its_top_and_its_rim():
    got = at(POLE, (4, 2, 3), (5, 2, 7), (6, 2, 6.0 + 0.85), (5, 2, 3)).obstacles
    np.testing.assert_allclose(got, [0.85, 1.0, np.hypot(0.85, 0.85), -0.15])


def test_nothing_is_infinitely_far():
    got = at(World("empty"), (0, 0, 0))
    assert got.obstacles[0] == got.trees[0] == np.inf
    assert at(POLE, (4, 2, 3)).trees[0] == np.inf


@pytest.mark.parametrize(("wide", "tall"), [(1.2, 1.0), (0.5, 1.2), (1.0, 1.0), (2.0, 0.3)])
def test_a_canopy_is_measured_to_its_nearest_point(wide, tall):
    centre, axes = np.array([3.0, -1.0, 1.6]), np.array([wide, wide, tall])
    points = centre + np.random.default_rng(2).uniform(-3, 3, (60, 3))
    points[:3] = (3.0, -1.0, 1.6), (3.0, -1.0, 4.0), (5.0, -1.0, 1.6)
    a, b = np.meshgrid(np.linspace(0, 2 * np.pi, 360), np.linspace(0, np.pi, 361))
    ball = np.stack([np.sin(b) * np.cos(a), np.sin(b) * np.sin(a), np.cos(b)], axis=-1)
    surface = centre + axes * ball.reshape(-1, 3)
    want = np.array([np.linalg.norm(surface - point, axis=1).min() for point in points])
    want *= np.where((((points - centre) / axes) ** 2).sum(axis=1) < 1, -1, 1)
    solids = np.array([[*centre, wide, tall], [60.0, 0.0, 1.6, wide, tall]])
    got = module.spheroid_distances(points, solids).min(axis=1)
    np.testing.assert_allclose(got, want, atol=5e-3)


def test_a_trunk_below_the_canopy_is_part_of_the_tree():
    world = World("tree", trees=(Tree(0.0, 0.0, height=4.0, canopy_height=1.0, trunk_radius=0.1),))
    assert at(world, (1.0, 0.0, 0.5)).trees[0] == pytest.approx(0.9)


def test_a_wire_hangs_by_its_sag_at_mid_span():
    wire = Wire(np.array([0.0, 0, 5]), np.array([30.0, 0, 5]), 1.0, 0.01)
    world = World("wire", wires=(wire,))
    assert at(world, (15, 0, 4.0)).obstacles[0] == pytest.approx(-0.01)
    assert at(world, (15, 0, 3.0)).obstacles[0] == pytest.approx(0.99)
    assert at(world, (0, 0, 5.5)).obstacles[0] == pytest.approx(0.49)
    x = np.linspace(0, 30, 500)
    parabola = np.column_stack([x, 0 * x, 5 - 4 * (x / 30) * (1 - x / 30)])
    assert np.abs(at(world, *parabola).obstacles + 0.01).max() < 1.0 / 200
    assert len(wire_capsules(wire)) == 16


def test_a_turned_box_is_measured_in_its_own_frame():
    world = World("box", boxes=(Box(np.array([1.0, 1, 1]), np.array([4.0, 2, 2]), np.pi / 2),))
    got = at(world, (1, 4, 1), (3, 1, 1), (1, 1, 3), (1, 1, 1), (3, 4, 1)).obstacles
    np.testing.assert_allclose(got, [1, 1, 1, -1, np.hypot(1, 1)], atol=1e-12)


def test_a_person_walks_there_and_back():
    person = Person(np.array([0.0, 0]), np.array([10.0, 0]), 2.0, start=1.0)
    where = walker_at(person, np.array([-5.0, 1, 2, 6, 7, 11, 13]))
    np.testing.assert_allclose(where[:, 0], [0, 0, 2, 10, 8, 0, 4])
    world = World("walk", people=(person,))
    got = at(world, (4, 0, 1), (4, 0, 1), times=np.array([3.0, 6.0])).obstacles
    np.testing.assert_allclose(got, [-0.3, 5.7])


def test_standing_still_is_no_division_by_zero():
    for person in (
        Person(np.zeros(2), np.zeros(2), 1.0),
        Person(np.zeros(2), np.array([1.0, 0]), 0.0),
    ):
        np.testing.assert_array_equal(walker_at(person, np.array([0.0, 9.0])), np.zeros((2, 2)))


def test_many_points_are_measured_piece_by_piece_with_the_same_result(monkeypatch):
    world = World(
        "row", trees=tuple(Tree(3.0 * n, 0.0) for n in range(8)), poles=POLE.poles,
        boxes=(Box(np.array([1.0, 1, 1]), np.array([4.0, 2, 2]), 0.3),),
    )  # fmt: skip
    points = np.random.default_rng(1).uniform(-5, 25, (300, 3))
    whole = clearance(world, points)
    monkeypatch.setattr(module, "_ROOM", 50)
    pieces = clearance(world, points)
    np.testing.assert_array_equal(whole.trees, pieces.trees)
    np.testing.assert_array_equal(whole.obstacles, pieces.obstacles)
    np.testing.assert_array_equal(whole.nearest, np.minimum(whole.trees, whole.obstacles))
