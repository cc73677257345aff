"""A detector with a trained network: an ONNX model of the YOLO family, by its file.

The only file that imports onnxruntime (extra `vision`). Fits perception/eyes.py `Detector`.
"""

from __future__ import annotations

import ast
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.input_text import decoded, read_bounded
from orchard_cli.model.obstacles import Category, Detection
from orchard_cli.model.sensors import ColourFrame
from orchard_cli.model.vehicle import Pose

from .letterbox import letterbox
from .suppress import suppress
from .yolo import NotYolo, candidates

LARGEST = 512 * 2**20  # bytes of a model
LARGEST_NAMES = 64 * 2**10
MOST_CLASSES = 1_000
SIDES = (32, 2048)  # px, of the picture
DEFAULT_SIDE = 640  # px, where the model takes any
STALE = 0.5  # s between the colour and the depth image

MEANINGS = {
    "person": Category.PERSON,
    "people": Category.PERSON,
    "pedestrian": Category.PERSON,
    "tree": Category.TREE,
    "building": Category.BUILDING,
    "house": Category.BUILDING,
    "power line": Category.POLE,
    "power line/tower": Category.POLE,
    "power-line pole/tower": Category.POLE,
    "pole": Category.POLE,
    "utility pole": Category.POLE,
    "tower": Category.POLE,
    "wire": Category.WIRE,
    "cable": Category.WIRE,
    "drone": Category.DRONE,
    "uav": Category.DRONE,
}
"""Class names that say something here, in small letters; the paper's power line is its pole."""


@dataclass(frozen=True, slots=True)
class OnnxSettings:
    """What is believed of a network."""

    score: float = 0.4  # least
    overlap: float = 0.5  # intersection over union above which two boxes are one
    threads: int = 1


class OnnxDetector:
    """Looks for things in colour images."""

    needs = frozenset({"colour"})

    def __init__(
        self, session: Any, names: tuple[str, ...], file: str, settings: OnnxSettings
    ) -> None:
        self._session = session
        self._meanings = tuple(MEANINGS.get(name.strip().lower()) for name in names)
        self._file = file
        self._settings = settings
        self._input = session.get_inputs()[0].name
        self._sides = _sides(session, file)
        self._last: tuple[float, tuple[Detection, ...]] = (-math.inf, ())  # time, what was found

    @classmethod
    def load(
        cls, path: Path, names: Path | None = None, settings: OnnxSettings | None = None
    ) -> OnnxDetector:
        """Open a model; its class names come from its metadata, or from a file with one a line.

        Raises InputError for a file that is no such model, or whose classes mean nothing here.
        """
        settings = settings or OnnxSettings()
        session = _session(path, settings)
        known = _names_in(session, path) if names is None else _names_file(names)
        if not any(name.strip().lower() in MEANINGS for name in known):
            raise InputError(
                Fault(path.name, "none of its classes means anything here",
                      f"known are {', '.join(MEANINGS)}")
            )  # fmt: skip
        detector = cls(session, known, path.name, settings)
        detector.try_out()
        return detector

    def try_out(self) -> None:
        """Run once on a grey picture. Raises InputError when the model is none of the family."""
        grey = np.full((*self._sides[::-1], 3), 114, dtype=np.uint8)
        self.find(grey)

    def detect(
        self, frame: DepthFrame, pose: Pose, colour: ColourFrame | None
    ) -> tuple[Detection, ...]:
        """Boxes in the depth image's pixels; none without a colour image of about its time."""
        del pose
        if colour is None or abs(colour.time - frame.time) > STALE:
            return ()
        if colour.rgb.shape[:2] != (frame.camera.height, frame.camera.width):
            return ()
        if colour.time != self._last[0]:
            self._last = (colour.time, self.find(colour.rgb))
        return self._last[1]

    def find(self, rgb: np.ndarray[Any, np.dtype[np.uint8]]) -> tuple[Detection, ...]:
        """Everything with a meaning in a colour image (h, w, 3)."""
        s = self._settings
        boxed = letterbox(rgb, *self._sides)
        try:
            output = self._session.run(None, {self._input: boxed.picture[None]})[0]
            found = candidates(np.asarray(output), len(self._meanings), s.score)
        except NotYolo as error:
            raise InputError(
                Fault(self._file, f"is no YOLO model: {error}", "export it to ONNX with its names")
            ) from None
        except Exception as error:  # whatever the vendor's library raises, the model is at fault
            raise InputError(
                Fault(self._file, f"does not run: {_first_line(error)}", "export it again")
            ) from error
        kept = suppress(found.boxes, found.scores, found.classes, s.overlap)
        edges = boxed.boxes_image(found.boxes[kept])
        limit = np.array([rgb.shape[1], rgb.shape[0]] * 2) - 0.5
        edges = np.clip(edges, -0.5, limit)
        detections = []
        for k, (left, top, right, bottom) in zip(kept, edges.tolist(), strict=True):
            category = self._meanings[int(found.classes[k])]
            if category is not None and left < right and top < bottom:
                score = float(found.scores[k])
                detections.append(Detection(category, score, left, top, right, bottom))
        return tuple(detections)


def _session(path: Path, settings: OnnxSettings) -> Any:
    try:
        import onnxruntime as ort
    except ImportError:
        raise InputError(
            Fault("--detector", "onnxruntime is not installed",
                  "install it with: pip install 'orchard-cli[vision]'")
        ) from None  # fmt: skip
    data = read_bounded(path, LARGEST, "a smaller model is faster, too")
    options = ort.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = settings.threads
    options.log_severity_level = 4
    try:
        session = ort.InferenceSession(data, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # the vendor's library has no common root of its errors
        raise InputError(
            Fault(path.name, f"is no ONNX model: {_first_line(error)}", "export it again")
        ) from None
    inputs = session.get_inputs()
    if len(inputs) != 1 or inputs[0].type != "tensor(float)" or len(inputs[0].shape) != 4:
        raise InputError(
            Fault(path.name, "does not take one picture of floats", "export a YOLO model to ONNX")
        )
    return session


def _sides(session: Any, file: str) -> tuple[int, int]:
    """Width and height of the picture, px."""
    _, channels, height, width = session.get_inputs()[0].shape
    sides = tuple(side if isinstance(side, int) else DEFAULT_SIDE for side in (width, height))
    low, high = SIDES
    if channels not in (3, "channels") or not all(low <= side <= high for side in sides):
        raise InputError(
            Fault(file, f"takes pictures of {channels} x {height} x {width}",
                  f"export it for 3 colours and {low} to {high} px")
        )  # fmt: skip
    return sides[0], sides[1]


def _names_in(session: Any, path: Path) -> tuple[str, ...]:
    """The class names in a model's metadata: "{0: 'person', ...}", or a list."""
    mend = "give a file with a name a line with --detector-names"
    text = session.get_modelmeta().custom_metadata_map.get("names", "")
    if not text:
        raise InputError(Fault(path.name, "does not tell its class names", mend))
    try:
        names = ast.literal_eval(text) if len(text) <= LARGEST_NAMES else None
    except (ValueError, SyntaxError, RecursionError, MemoryError):
        names = None
    if isinstance(names, dict) and sorted(map(repr, names)) == sorted(map(repr, range(len(names)))):
        names = [names[k] for k in range(len(names))]
    if not isinstance(names, list) or not 0 < len(names) <= MOST_CLASSES:
        raise InputError(Fault(path.name, "its class names cannot be read", mend))
    return tuple(str(name) for name in names)


def _names_file(path: Path) -> tuple[str, ...]:
    text = decoded(read_bounded(path, LARGEST_NAMES, "one class name a line"), path.name)
    names = tuple(line.strip() for line in text.splitlines() if line.strip())
    if not 0 < len(names) <= MOST_CLASSES:
        raise InputError(Fault(path.name, "holds no class names", "write one a line"))
    return names


def _first_line(error: Exception) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:200]
