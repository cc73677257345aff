"""A small network that finds colours: red is class 0, green 1, blue 2, in a grid of 8 x 8 cells."""

from __future__ import annotations

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

SIDE, CELL = 64, 8
CELLS = SIDE // CELL
CENTRES = np.array([[CELL * (u + 0.5), CELL * (v + 0.5)]
                    for v in range(CELLS) for u in range(CELLS)], dtype=np.float32)  # fmt: skip
NAMES = "{0: 'person', 1: 'tree', 2: 'giraffe'}"


def model(layout="v8", names=NAMES, side=SIDE, channels=3) -> bytes:
    """The layouts of perception/yolo.py: v8, v5 and end."""
    n = CELLS * CELLS
    size = np.full_like(CENTRES, CELL)
    boxes = np.hstack([CENTRES, size])
    nodes = [
        helper.make_node("AveragePool", ["image"], ["cells"], kernel_shape=[CELL, CELL],
                         strides=[CELL, CELL]),
        helper.make_node("Reshape", ["cells", "shape"], ["scores"]),
    ]  # fmt: skip
    stored = {"shape": np.array([1, 3, n], dtype=np.int64)}
    if layout == "v8":
        stored["boxes"] = boxes.T[None]
        nodes.append(helper.make_node("Concat", ["boxes", "scores"], ["found"], axis=1))
        shape = [1, 7, n]
    elif layout == "v5":
        stored["boxes"] = np.hstack([boxes, np.ones((n, 1), dtype=np.float32)])[None]
        nodes.append(helper.make_node("Transpose", ["scores"], ["rows"], perm=[0, 2, 1]))
        nodes.append(helper.make_node("Concat", ["boxes", "rows"], ["found"], axis=2))
        shape = [1, n, 8]
    elif layout == "end":
        stored["boxes"] = np.hstack([CENTRES - CELL / 2, CENTRES + CELL / 2])[None]
        nodes += [
            helper.make_node("Transpose", ["scores"], ["rows"], perm=[0, 2, 1]),
            helper.make_node("ArgMax", ["rows"], ["which"], axis=2, keepdims=1),
            helper.make_node("Cast", ["which"], ["kind"], to=TensorProto.FLOAT),
            helper.make_node("ReduceMax", ["rows", "axes"], ["best"], keepdims=1),
            helper.make_node("Concat", ["boxes", "best", "kind"], ["found"], axis=2),
        ]
        stored["axes"] = np.array([2], dtype=np.int64)
        shape = [1, n, 6]
    else:  # the scores alone: no detector
        nodes.append(helper.make_node("Identity", ["scores"], ["found"]))
        shape = [1, 3, n]
    graph = helper.make_graph(
        nodes, "toy",
        [helper.make_tensor_value_info("image", TensorProto.FLOAT, [1, channels, side, side])],
        [helper.make_tensor_value_info("found", TensorProto.FLOAT, shape)],
        [numpy_helper.from_array(np.ascontiguousarray(v), name=k) for k, v in stored.items()],
    )  # fmt: skip
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=9)
    if names is not None:
        helper.set_model_props(made, {"names": names})
    onnx.checker.check_model(made)
    return made.SerializeToString()
