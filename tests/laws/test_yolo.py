"""Letterbox, suppression and the network's output."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.perception.letterbox import letterbox
from orchard_cli.perception.suppress import shared, suppress
from orchard_cli.perception.yolo import NotYolo, candidates


@settings(max_examples=20, deadline=None)
@given(st.integers(8, 200), st.integers(8, 200), st.sampled_from([(64, 64), (96, 64)]))
def test_a_box_comes_back_through_the_letterbox(rows, columns, size):
    box = letterbox(np.zeros((rows, columns, 3), dtype=np.uint8), *size)
    whole = np.array([[box.left, box.top, box.left + box.scale * columns,
                       box.top + box.scale * rows]])  # fmt: skip
    back = box.boxes_image(whole)[0]
    np.testing.assert_allclose(back, [-0.5, -0.5, columns - 0.5, rows - 0.5], atol=1e-9)
    assert box.picture.shape == (3, size[1], size[0])


def test_the_letterbox_keeps_shapes_and_pads_with_grey():
    rgb = np.zeros((40, 80, 3), dtype=np.uint8)
    rgb[:, :, 0] = 255
    box = letterbox(rgb, 64, 64)
    np.testing.assert_allclose(box.picture[0, 16:48], 1.0)
    np.testing.assert_allclose(box.picture[:, :16], 114 / 255)
    np.testing.assert_allclose(box.picture[1:, 16:48], 0.0)


boxes_of = st.lists(
    st.tuples(st.floats(0, 50), st.floats(0, 50), st.floats(1, 30), st.floats(1, 30),
              st.floats(0, 1), st.integers(0, 2)), max_size=25,
)  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(boxes_of)
def test_suppression_keeps_the_best_and_nothing_that_overlaps_it(rows):
    table = np.array(rows).reshape(-1, 6)
    boxes = np.hstack([table[:, :2], table[:, :2] + table[:, 2:4]])
    scores, kinds = table[:, 4], table[:, 5].astype(np.int64)
    kept = suppress(boxes, scores, kinds, 0.5)
    assert (np.diff(scores[kept]) <= 0).all()
    for i, k in enumerate(kept):
        for j in kept[:i]:
            if kinds[j] == kinds[k]:
                assert shared(boxes[j], boxes[k][None])[0] <= 0.5
    for n in set(range(len(boxes))) - set(kept.tolist()):
        better = [k for k in kept if kinds[k] == kinds[n] and scores[k] >= scores[n]]
        assert any(shared(boxes[k], boxes[n][None])[0] > 0.5 for k in better)


def test_what_is_not_finite_or_has_no_inside_is_dropped():
    rows = np.zeros((1, 5, 6), dtype=np.float32)
    rows[0, :, :6] = [
        [0, 0, 10, 10, 0.9, 1],
        [np.nan, 0, 10, 10, 0.9, 1],
        [10, 0, 0, 10, 0.9, 1],
        [0, 0, 10, 10, np.inf, 1],
        [0, 0, 10, 10, 0.9, 9e30],
    ]
    found = candidates(rows, 3, 0.5)
    assert len(found.boxes) == 1
    assert found.classes.tolist() == [1]


@pytest.mark.parametrize("shape", [(1, 3), (2, 7, 10), (1, 9, 10), (1, 0, 0)])
def test_other_outputs_are_refused(shape):
    with pytest.raises(NotYolo):
        candidates(np.zeros(shape, dtype=np.float32), 3, 0.5)
