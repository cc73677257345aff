"""A YOLO-family model by its file: a small one that the tests make, in each layout."""

import numpy as np
import pytest

from orchard_cli.errors import InputError
from orchard_cli.model.depth import DepthFrame, d455
from orchard_cli.model.obstacles import Category
from orchard_cli.model.sensors import ColourFrame
from orchard_cli.perception.onnx_detector import OnnxDetector, OnnxSettings

from ..toy_yolo import model

SURE = OnnxSettings(score=0.6)
LAYOUTS = ["v8", "v5", "end"]


def stored(tmp_path, name="toy.onnx", data=None, **kwargs):
    path = tmp_path / name
    path.write_bytes(model(**kwargs) if data is None else data)
    return path


def picture(colour, rows, columns, shape=(120, 212)):
    rgb = np.zeros((*shape, 3), dtype=np.uint8)
    rgb[rows, columns, colour] = 255
    return rgb


@pytest.mark.parametrize("layout", LAYOUTS)
def test_finds_a_tree_where_it_is(tmp_path, layout):
    """212 x 120 px fit into 64 x 64 with a scale of 0.302 and bars of 14 px: a cell of the network
    covers 26.5 px."""
    detector = OnnxDetector.load(stored(tmp_path, layout=layout), settings=SURE)
    found = detector.find(picture(1, slice(40, 80), slice(106, 150)))
    assert {one.category for one in found} == {Category.TREE}
    assert min(one.left for one in found) == pytest.approx(106 - 0.5, abs=0.6)
    assert all(-0.5 <= one.left < one.right <= 211.5 for one in found)
    assert all(20 < one.centre[1] < 100 for one in found)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_layouts_agree(tmp_path, layout):
    rgb = picture(0, slice(0, 60), slice(0, 60))
    one, other = (
        OnnxDetector.load(stored(tmp_path, f"{name}.onnx", layout=name), settings=SURE).find(rgb)
        for name in ("v8", layout)
    )
    assert [d.category for d in one] == [d.category for d in other]
    np.testing.assert_allclose([d.left for d in one], [d.left for d in other], atol=1e-4)


def test_a_class_without_meaning_is_left_out(tmp_path):
    detector = OnnxDetector.load(stored(tmp_path), settings=SURE)
    assert detector.find(picture(2, slice(0, 120), slice(0, 212))) == ()


def test_names_come_from_a_file_too(tmp_path):
    names = tmp_path / "names.txt"
    names.write_text("drone\nPower line/Tower\nperson\n")
    detector = OnnxDetector.load(stored(tmp_path, names=None), names, SURE)
    found = detector.find(picture(2, slice(0, 120), slice(0, 212)))
    assert found
    assert {one.category for one in found} == {Category.PERSON}


def test_old_or_missing_colour_finds_nothing(tmp_path):
    detector = OnnxDetector.load(stored(tmp_path), settings=SURE)
    camera = d455(212, 120)
    frame = DepthFrame(10.0, np.zeros((120, 212), dtype=np.uint16), camera)
    green = picture(1, slice(0, 120), slice(0, 212))
    assert detector.detect(frame, None, None) == ()
    assert detector.detect(frame, None, ColourFrame(9.0, green, camera)) == ()
    assert detector.detect(frame, None, ColourFrame(9.9, green, camera))


@pytest.mark.parametrize(
    ("said", "kwargs"),
    [
        ("is no ONNX model", {"data": b"not a model"}),
        ("is no ONNX model", {"data": b""}),
        ("is no ONNX model", {"data": model()[:-40]}),
        ("does not tell its class names", {"names": None}),
        ("class names cannot be read", {"names": "{0: __import__('os')}"}),
        ("class names cannot be read", {"names": "[" * 5000}),
        ("class names cannot be read", {"names": "{0: 'person', 7: 'tree'}"}),
        ("means anything here", {"names": "['cat', 'dog', 'cow']"}),
        ("is no YOLO model", {"names": "['person', 'tree']"}),
        ("is no YOLO model", {"layout": "scores"}),
    ],
)
def test_a_hostile_or_wrong_model_is_one_line(tmp_path, said, kwargs):
    with pytest.raises(InputError, match=said) as caught:
        OnnxDetector.load(stored(tmp_path, **kwargs), settings=SURE)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 2


def test_a_missing_model_is_one_line(tmp_path):
    with pytest.raises(InputError, match="is no file"):
        OnnxDetector.load(tmp_path / "none.onnx")
    with pytest.raises(InputError, match="is no regular file"):
        OnnxDetector.load(tmp_path)
