"""The simulated colour camera: pixel by pixel what the depth camera sees."""

import numpy as np
import pytest

from orchard_cli.geometry.rotations import from_yaw_pitch_roll
from orchard_cli.model.depth import d455
from orchard_cli.model.sensors import ColourFrame
from orchard_cli.model.world import Box, Person, Pole, Tree, World
from orchard_cli.simulator import SimulatorSettings
from orchard_cli.simulator.run import Run
from orchard_cli.simulator.scene import Scene

CAMERA = d455(212, 120)
THINGS = {
    "green": World("", trees=(Tree(5.0, 0.0, height=4.0, canopy_height=3.0),)),
    "red": World("", people=(Person(np.array([3.0, 0]), np.array([3.0, 0]), 0.0, height=2.2),)),
    "pale": World("", boxes=(Box(np.array([6.0, 0, 2]), np.array([2.0, 2, 4]), 0.3),)),
    "brown": World("", poles=(Pole(3.0, 0.0, 0.3, 6.0),)),
}


def middle(world, number=1):
    image = Scene(world).colours(
        CAMERA, np.array([0.0, 0, 1.5]), from_yaw_pitch_roll(0.0), 0.0, number
    )
    return image, image[58:62, 104:108].reshape(-1, 3).mean(axis=0)


@pytest.mark.parametrize("look", THINGS)
def test_each_kind_has_its_colour(look):
    _, (red, green, blue) = middle(THINGS[look])
    expected = {
        "green": green > 1.3 * red and green > 1.3 * blue,
        "red": red > 1.8 * green,
        "pale": min(red, green, blue) > 60 and max(red, green, blue) < 1.3 * min(red, green, blue),
        "brown": red > green > blue,
    }
    assert expected[look]


def test_the_sky_is_bright_and_the_same_seed_gives_the_same_picture():
    one, _ = middle(THINGS["brown"])
    other, _ = middle(THINGS["brown"])
    third, _ = middle(THINGS["brown"], number=2)
    np.testing.assert_array_equal(one, other)
    assert (one != third).any()
    assert one[:10, :20].mean() > 150


@pytest.mark.parametrize("wanted", [frozenset(), frozenset({"colour"})])
def test_pictures_come_only_when_a_system_asks_for_them(wanted):
    settings = SimulatorSettings(camera=(212, 120), sensors=wanted)
    run = Run(World(""), (0.0, 0.0), 0.0, settings)
    scans = [scan for _ in range(60) for scan in run.step().scans]
    assert {type(scan) for scan in scans} == ({ColourFrame} if wanted else set())
    assert all(scan.rgb.shape == (120, 212, 3) for scan in scans)
