"""The flight from the side: height over the distance flown, ground and canopies below."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.mission import Leg, Mission

from .course import Course, course
from .sketch import HEADLAND, TRANSIT, Label, Path, Shape, Sketch, Style

_SHAPE = 0.26  # height of the chart over its width
_STEP = 0.25  # m between samples
_REACH = 1.5  # m beside the flight within which a tree is drawn below it
_GRID = Style(stroke="#cfd8dc", width=1.0)
_SOIL = Style(fill="#bcaaa4", opacity=0.8)
_CANOPY = Style(fill="#9ccc65", opacity=0.8)


def side_view(mission: Mission, colour: str) -> Sketch:
    """Heights are stretched so that the chart keeps its shape; its labels tell metres."""
    way = course(mission)
    steps = np.linalg.norm(np.diff(way.points_site, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    at = np.linspace(0.0, along[-1], max(int(along[-1] / _STEP), 2))
    path = np.column_stack([np.interp(at, along, axis) for axis in way.points_site.T])
    ground, tops = _below(mission, path)
    bottom = float(min(ground.min(), 0.0))
    top = float(max(path[:, 2].max(), tops.max()))
    stretch = _SHAPE * float(along[-1]) / max(top - bottom, 1e-6)

    def placed(x: Array, z: Array) -> Points:
        return np.column_stack([x, (z - bottom) * stretch])

    width, height = float(along[-1]), (top - bottom) * stretch
    shapes = _grid(width, bottom, top, stretch)
    base = placed(at[[-1, 0]], np.full(2, bottom) - 0.04 * height / stretch)
    shapes.append(Path(np.concatenate([placed(at, tops), base]), _CANOPY, closed=True))
    shapes.append(Path(np.concatenate([placed(at, ground), base]), _SOIL, closed=True))
    shapes += _flight(way, along, colour, placed)
    low = np.array([-0.045 * width, -0.25 * height])
    return Sketch(tuple(shapes), low, np.array([1.02 * width, 1.12 * height]))


def _below(mission: Mission, path: Points) -> tuple[Array, Array]:
    """Ground (n,) and the top of what grows (n,) below a path (n, 3), m."""
    trunks = np.concatenate([row.trunks_site for row in mission.orchard.rows])
    tops = np.concatenate([row.canopy_tops_site for row in mission.orchard.rows])
    soil, grown = np.empty(len(path)), np.empty(len(path))
    for k, place in enumerate(path[:, :2]):
        apart = np.hypot(*(trunks - place).T)
        soil[k] = mission.orchard.ground_near(place)
        grown[k] = max(soil[k], tops[apart <= _REACH].max(initial=-np.inf))
    return soil, grown


def _grid(width: float, bottom: float, top: float, stretch: float) -> list[Shape]:
    shapes: list[Shape] = []
    for z in _round_numbers(bottom, top, 4):
        y = (z - bottom) * stretch
        shapes.append(Path(np.array([[0.0, y], [width, y]]), _GRID))
        shapes.append(Label(-0.008 * width, y - 0.006 * width, f"{z:g}", anchor="end", size=0.8))
    for x in _round_numbers(0.0, width, 6):
        y = -0.18 * (top - bottom) * stretch
        shapes.append(Label(x, y, f"{x:g} m" if x else "0", size=0.8))
    return shapes


def _round_numbers(low: float, high: float, about: int) -> list[float]:
    raw = max(high - low, 1e-6) / about
    power = 10 ** np.floor(np.log10(raw))
    step = float(min((m * power for m in (1, 2, 5, 10)), key=lambda s: abs(s - raw)))
    return [float(v) for v in np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step]


def _flight(
    way: Course, along: Array, colour: str, placed: Callable[[Array, Array], Points]
) -> list[Shape]:
    styles = {Leg.ROW: Style(stroke=colour, width=3.0), Leg.HEADLAND: HEADLAND,
              Leg.TRANSIT: TRANSIT}  # fmt: skip
    return [
        Path(placed(along[k : k + 2], way.points_site[k : k + 2, 2]), styles[leg.leg])
        for k, leg in enumerate(way.ways)
    ]
