"""The airframe touches what it is near, and the toucher is told by name."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.geometry.clearance import clearance
from orchard_cli.model.world import Box, Person, Pole, Tree, Wire, World
from orchard_cli.simulator.scene import Scene

CROWD = World(
    "one of each",
    trees=(Tree(30.0, 0.0), Tree(3.0, 0.0)),
    poles=(Pole(4.0, -2.0, 0.15, 3.0),),
    wires=(Wire(np.array([0.0, -4, 3]), np.array([6.0, 4, 4]), 0.5, 0.06),),
    boxes=(Box(np.array([5.0, -1.0, 2.0]), np.array([1.0, 2, 1.5]), 0.7),),
    people=(Person(np.array([2.0, -1]), np.array([2.0, -3]), 1.0),),
)


@settings(max_examples=150, deadline=None)
@given(st.floats(-2, 8), st.floats(-5, 5), st.floats(0, 5), st.floats(0, 9), st.floats(0.1, 1))
def test_contact_is_told_exactly_when_the_clearance_is_used_up(x, y, z, time, radius):
    point = np.array([x, y, z])
    near = clearance(CROWD, point[None], np.array([time])).nearest[0]
    if abs(near - radius) > 1e-9:
        assert (Scene(CROWD).contact(point, radius, time) is not None) == (near < radius)


@pytest.mark.parametrize(
    ("point", "name"),
    [
        ((30.0, 0.0, 2.0), "tree 1"), ((3.0, 0.1, 0.3), "tree 2"), ((4.2, -2.0, 2.9), "pole 1"),
        ((0.0, -4.0, 3.1), "wire 1"), ((5.0, -1.0, 2.8), "box 1"), ((2.0, -1.1, 1.0), "person 1"),
        ((-5.0, 0.0, 0.0), None),
    ],
)  # fmt: skip
def test_what_is_touched_is_named(point, name):
    assert Scene(CROWD).contact(np.array(point), 0.1, 0.0) == name


def test_an_empty_world_touches_nothing_and_is_infinitely_far():
    scene = Scene(World("empty"))
    assert scene.contact(np.zeros(3), 1.0, 0.0) is None
    assert scene.clearance(np.zeros(3), 0.0).nearest[0] == np.inf
