"""World files say what stands where, and a wrong one is refused with all its faults."""

import contextlib
import math
import os

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchard_cli.errors import InputError
from orchard_cli.model.site import HeightReference, KnownObstacle, Orchard, SiteOrigin, TreeRow
from orchard_cli.simulator import world_file

ORCHARD = Orchard(
    "two rows",
    SiteOrigin(23.45, 112.68, 50.0, HeightReference.AMSL, 0.3),
    rows=(
        TreeRow(np.array([[0.0, 0], [3, 0]]), np.zeros(2), np.array([2.6, 1.5])),
        TreeRow(np.array([[1.0, 6]]), np.array([0.4]), np.array([3.0])),
    ),
    obstacles=(KnownObstacle(np.array([1.5, 0.0]), 0.15, 6.0),),
)

WHOLE = """
name = "lemon"
seed = 7
trees = "survey"

[tree_defaults]
canopy_radius_m = 1.0

[[tree]]
x_m = 20
y_m = -3.5
height_m = 4

[[pole]]
x_m = 19.0
y_m = 6.0
radius_m = 0.15
height_m = 6.0

[[wire]]
a_m = [0, 0, 5]
b_m = [30.0, 0.0, 6.0]
sag_m = 0.5
radius_m = 0.005

[[box]]
centre_m = [1, 2, 3]
size_m = [1, 2, 0.5]
yaw_deg = 90

[[person]]
a_m = [0, 3]
b_m = [10, 3]
speed_m_s = 1.2

[wind]
speed_m_s = 2.0
towards_deg = 90
gust_m_s = 0.5

[noise]
disparity_px = 0.2
attitude_deg = 1.0
"""


def faults_of(text, orchard=None):
    with pytest.raises(InputError) as caught:
        world_file.parse(text, "w.toml", orchard)
    assert caught.value.exit_code == 2
    return [str(fault) for fault in caught.value.faults]


def test_everything_that_a_file_names_is_in_the_world():
    world = world_file.parse(WHOLE, "w.toml", ORCHARD)
    assert (world.name, world.seed) == ("lemon", 7)
    assert [(t.x, t.y, t.ground, t.height) for t in world.trees] == [
        (0, 0, 0, 2.6), (3, 0, 0, 1.5), (1, 6, 0.4, 3.0), (20, -3.5, 0, 4.0),
    ]  # fmt: skip
    assert {t.canopy_radius for t in world.trees} == {1.0}
    assert all(t.canopy_height <= t.height for t in world.trees)
    (pole,), (wire,), (box,), (person,) = world.poles, world.wires, world.boxes, world.people
    assert (pole.x, pole.y, pole.radius, pole.height) == (19.0, 6.0, 0.15, 6.0)
    np.testing.assert_array_equal([wire.a_site, wire.b_site], [[0, 0, 5], [30, 0, 6]])
    assert (wire.sag, wire.radius) == (0.5, 0.005)
    assert box.yaw == pytest.approx(math.pi / 2)
    np.testing.assert_array_equal(box.size, [1, 2, 0.5])
    np.testing.assert_array_equal([person.a_site, person.b_site], [[0, 3], [10, 3]])
    assert person.speed == 1.2
    np.testing.assert_allclose(world.wind.velocity_site, [0, 2, 0], atol=1e-12)  # to the left
    assert world.wind.gust == 0.5
    assert (world.noise.disparity_px, world.noise.dropout) == (0.2, 0.002)
    assert world.noise.attitude == pytest.approx(math.radians(1.0))


def test_an_empty_file_is_an_empty_world():
    world = world_file.parse("", "flat.toml")
    assert world.name == "flat"
    things = (*world.trees, *world.poles, *world.wires, *world.boxes, *world.people)
    assert len(things) == 0


def test_a_survey_alone_makes_a_world_with_its_trees_and_obstacles():
    world = world_file.from_orchard(ORCHARD)
    assert [(t.x, t.y, t.height) for t in world.trees] == [(0, 0, 2.6), (3, 0, 1.5), (1, 6, 3.0)]
    (pole,) = world.poles
    assert (pole.x, pole.y, pole.radius, pole.height) == (1.5, 0.0, 0.15, 6.0)


def test_all_faults_are_told_together_with_their_places():
    faults = faults_of(
        """
        name = 3
        sead = 4
        trees = "survey"
        [[pole]]
        x_m = "a"
        y_m = nan
        radius_m = -1
        height_m = true
        [[pole]]
        x_m = 1
        y_m = 1e9
        radius_m = 0.1
        height_m = 3
        colour = "red"
        [[wire]]
        a_m = [1, 2]
        b_m = [1, 2, inf]
        [noise]
        dropout = 2
        """
    )
    told = "\n".join(faults)
    for place in (
        "name", "sead", "trees", "pole[1].x_m", "pole[1].y_m", "pole[1].radius_m",
        "pole[1].height_m", "pole[2].y_m", "pole[2].colour", "wire[1].a_m", "wire[1].b_m",
        "wire[1].radius_m", "noise.dropout",
    ):  # fmt: skip
        assert f"w.toml, {place}: " in told
    assert len(faults) == 13


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("x = ", "w.toml"),
        ("pole = 3", "pole"),
        ("pole = [1, 2]", "pole"),
        ("[pole]\nx_m = 1", "pole"),
        ("wind = 3", "wind"),
        ("trees = 'all'", "trees"),
        ("seed = 1.5", "seed"),
        ("seed = true", "seed"),
        ("seed = -1", "seed"),
        ("[[tree]]\nx_m = 0\ny_m = 0\nheight_m = 1\ncanopy_height_m = 2", "canopy_height_m"),
        ("[[wire]]\na_m = [1, 2, 3]\nb_m = [1, 2, 3]\nradius_m = 0.01", "b_m"),
        ("[[box]]\ncentre_m = [1, 2, 3]\nsize_m = [1, 0, 3]", "size_m"),
        ("tree = [" + "{x_m = 1, y_m = 1}," * 20_001 + "]", "tree"),
    ],
)
def test_each_of_these_is_refused_with_one_fault(text, where):
    (fault,) = faults_of(text)
    assert where in fault
    assert len(fault) < 300


def test_a_file_that_is_missing_or_no_text_is_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    for name, what in (
        ("none.toml", "is no file"),
        ("", "no regular"),
        ("pipe.toml", "no regular"),
    ):
        with pytest.raises(InputError, match=what):
            world_file.load(tmp_path / name)
    (tmp_path / "latin.toml").write_bytes(b'seed = 1\nname = "Orangerie \xe0 c\xf4t\xe9"\n')
    with pytest.raises(InputError, match=r"line 2: is not UTF-8"):
        world_file.load(tmp_path / "latin.toml")
    (tmp_path / "huge.toml").write_bytes(b"#" * (world_file.LARGEST_FILE + 1))
    with pytest.raises(InputError, match="4 MB is the most"):
        world_file.load(tmp_path / "huge.toml")
    (tmp_path / "good.toml").write_text(WHOLE)
    assert world_file.load(tmp_path / "good.toml", ORCHARD).name == "lemon"


def test_a_world_comes_with_the_bytes_of_its_file(tmp_path):
    data = b"\xef\xbb\xbf" + WHOLE.encode()
    (tmp_path / "w.toml").write_bytes(data)
    world, read = world_file.load_with_bytes(tmp_path / "w.toml", ORCHARD)
    assert (world.name, read) == ("lemon", data)


values = st.recursive(
    st.one_of(st.integers(), st.floats(), st.booleans(), st.text("ab", max_size=3)),
    lambda inner: st.lists(inner, max_size=3),
    max_leaves=4,
)
KEYS = ("x_m", "y_m", "a_m", "b_m", "size_m", "centre_m", "radius_m", "height_m", "sag_m", "seed",
        "speed_m_s", "yaw_deg", "trees", "pole", "wind", "canopy_height_m")  # fmt: skip
HEADS = ("[[pole]]", "[[wire]]", "[[box]]", "[[person]]", "[[tree]]", "[wind]", "[noise]")


@given(
    st.lists(
        st.tuples(
            st.sampled_from(HEADS), st.dictionaries(st.sampled_from(KEYS), values, max_size=4)
        ),
        max_size=4, unique_by=lambda part: part[0],
    )
)  # fmt: skip
def test_no_file_ends_in_anything_but_a_world_or_faults(parts):
    def toml(value):
        if isinstance(value, bool):
            return str(value).lower()
        if isinstance(value, list):
            return "[" + ", ".join(map(toml, value)) + "]"
        return f'"{value}"' if isinstance(value, str) else str(value)

    text = "\n".join(
        "\n".join([head, *(f"{key} = {toml(value)}" for key, value in table.items())])
        for head, table in parts
    )
    with contextlib.suppress(InputError):
        world_file.parse(text, "w.toml")
