"""What a picture of missions shows, as shapes in metres: the SVG, the PNG and the page draw them.

y grows upwards here, as in the site frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Points
from orchard_cli.model.mission import Leg, Mission

from .course import Course, course

CANOPY = 1.1  # m, radius of a drawn canopy
_ROUTE_COLOURS = ("#1565c0", "#8e24aa", "#00838f", "#c2185b", "#5d4037", "#37474f")


@dataclass(frozen=True, slots=True)
class Style:
    """How a shape is drawn; widths are pixels, or metres where `metric`."""

    stroke: str = "none"
    width: float = 1.0
    fill: str = "none"
    dash: tuple[float, ...] = ()
    opacity: float = 1.0
    metric: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """A line or an area."""

    points: Points  # (n, 2) m
    style: Style
    closed: bool = False


@dataclass(frozen=True, slots=True)
class Disc:
    """A filled circle."""

    x: float
    y: float
    radius: float  # m
    style: Style
    title: str = ""


@dataclass(frozen=True, slots=True)
class Label:
    """A word; its size is a share of the picture's width."""

    x: float
    y: float
    text: str
    colour: str = "#263238"
    anchor: str = "middle"
    size: float = 1.0
    halo: bool = True


Shape = Path | Disc | Label

GROUND = Style(fill="#f4f1e8")
TREE = Style(fill="#7cb342", opacity=0.55)
TRUNK = Style(fill="#5d4037")
OBSTACLE = Style(fill="#212121", stroke="#ffffff", width=1.0)
CLEARANCE = Style(stroke="#d32f2f", width=1.0, dash=(3, 3))
FENCE = Style(stroke="#d32f2f", width=2.0, dash=(8, 4))
KEEP_OUT = Style(stroke="#b71c1c", width=1.5, fill="#ef9a9a", opacity=0.6)
HEADLAND = Style(stroke="#ef6c00", width=2.0)
TRANSIT = Style(stroke="#757575", width=1.6, dash=(2, 3))
START = Style(fill="#2e7d32", stroke="#ffffff", width=1.5)
END = Style(fill="#c62828", stroke="#ffffff", width=1.5)


@dataclass(frozen=True, slots=True, eq=False)
class Sketch:
    """Shapes, drawn in order, and what they cover."""

    shapes: tuple[Shape, ...]
    low: Points  # (2,) m
    high: Points  # (2,) m


def colour_of(k: int) -> str:
    """The colour of the k-th mission's spray lines, from 0."""
    return _ROUTE_COLOURS[k % len(_ROUTE_COLOURS)]


def plan_view(missions: list[Mission]) -> Sketch:
    """Orchard and routes from above, in the site frame; all missions are of one orchard."""
    orchard = missions[0].orchard
    courses = [course(mission) for mission in missions]
    everything = np.concatenate(
        [c.points_site[:, :2] for c in courses]
        + [row.trunks_site for row in orchard.rows]
        + [orchard.fence_site, *orchard.keep_outs_site]
        + [o.position_site[None] for o in orchard.obstacles]
    )
    span = float(np.ptp(everything, axis=0).max())
    margin = max(3.0, 0.09 * span)  # room for words beside the marks
    low, high = everything.min(axis=0) - margin, everything.max(axis=0) + margin
    low = low - [0.0, 0.09 * span]  # room for the scale and the compass
    frame = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    shapes: list[Shape] = [Path(frame, GROUND, closed=True)]
    shapes += [Path(ring, KEEP_OUT, closed=True) for ring in orchard.keep_outs_site]
    if len(orchard.fence_site):
        shapes.append(Path(orchard.fence_site, FENCE, closed=True))
    for k, (mission, way) in enumerate(zip(missions, courses, strict=True)):
        shapes += _strips(mission, way, colour_of(k))
    shapes += _trees(missions[0])
    for k, way in enumerate(courses):
        shapes += _route(way, colour_of(k), span)
    shapes += _obstacles(missions[0], span)
    for mission in missions:
        shapes += _ends(mission, span)
    shapes += _scale(low, span) + _compass(missions[0], low, high, span)
    return Sketch(tuple(shapes), low, high)


def _strips(mission: Mission, way: Course, colour: str) -> list[Shape]:
    """The treated strips, as wide as the swath."""
    style = Style(stroke=colour, width=mission.swath, opacity=0.13, metric=True)
    return [
        Path(way.points_site[k : k + 2, :2], style) for k, leg in enumerate(way.ways) if leg.sprays
    ]


def _trees(mission: Mission) -> list[Shape]:
    shapes: list[Shape] = []
    for number, row in enumerate(mission.orchard.rows, 1):
        for tree, ((x, y), height) in enumerate(zip(row.trunks_site, row.heights, strict=True), 1):
            title = f"row {number}, tree {tree}: {height:.1f} m"
            shapes.append(Disc(float(x), float(y), CANOPY, TREE, title))
            shapes.append(Disc(float(x), float(y), 0.12, TRUNK))
    return shapes


def _route(way: Course, colour: str, span: float) -> list[Shape]:
    """Legs by their kind, an arrow on each that is long enough, and the rows' numbers."""
    styles = {Leg.ROW: Style(stroke=colour, width=2.6), Leg.HEADLAND: HEADLAND,
              Leg.TRANSIT: TRANSIT}  # fmt: skip
    shapes: list[Shape] = []
    numbered: set[int] = set()
    for k, leg in enumerate(way.ways):
        a, b = way.points_site[k, :2], way.points_site[k + 1, :2]
        style = styles[leg.leg]
        shapes.append(Path(np.array([a, b]), style))
        length = float(np.hypot(*(b - a)))
        if length > 0.06 * span:
            shapes.append(_arrow((a + b) / 2, (b - a) / length, 0.014 * span, style.stroke))
        if leg.row is not None and leg.row not in numbered and length > 0:
            numbered.add(leg.row)
            x, y = a + (b - a) / length * 0.03 * span
            shapes.append(Label(float(x), float(y) + 0.012 * span, str(leg.row + 1), colour))
    return shapes


def _arrow(at: Points, way: Points, size: float, colour: str) -> Path:
    left = np.array([-way[1], way[0]])
    tip = np.array([at + way * size, at - way * size + left * size * 0.8, at - way * size * 0.5,
                    at - way * size - left * size * 0.8])  # fmt: skip
    return Path(tip, Style(fill=colour), closed=True)


def _obstacles(mission: Mission, span: float) -> list[Shape]:
    shapes: list[Shape] = []
    for obstacle in mission.orchard.obstacles:
        x, y = (float(v) for v in obstacle.position_site)
        reach = obstacle.radius + mission.limits.clearance
        shapes.append(Disc(x, y, reach, CLEARANCE))
        shapes.append(Disc(x, y, max(obstacle.radius, 0.006 * span), OBSTACLE, obstacle.name))
        shapes.append(Label(x, y + reach + 0.008 * span, obstacle.name, "#b71c1c", size=0.8))
    return shapes


def _ends(mission: Mission, span: float) -> list[Shape]:
    """Where it takes off and lands; one mark where both are one place."""
    start, end = mission.takeoff_site, mission.landing_site
    size = 0.013 * span
    together = np.hypot(*(start - end)) < 2 * size
    marks = [(start, START, "take-off, landing" if together else "take-off")]
    if not together:
        marks.append((end, END, "landing"))
    shapes: list[Shape] = []
    for (x, y), style, word in marks:
        shapes.append(Disc(float(x), float(y), size, style, word))
        shapes.append(Label(float(x), float(y) - 3.0 * size, word, style.fill, size=0.8))
    return shapes


def _scale(low: Points, span: float) -> list[Shape]:
    """A bar of a round length."""
    length = max(s for s in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000) if s <= max(0.3 * span, 1))
    x, y = float(low[0]) + 0.04 * span, float(low[1]) + 0.035 * span
    bar = Path(np.array([[x, y], [x + length, y]]), Style(stroke="#263238", width=3))
    return [bar, Label(x + length / 2, y + 0.012 * span, f"{length} m", size=0.8)]


def _compass(mission: Mission, low: Points, high: Points, span: float) -> list[Shape]:
    """North, from the compass heading of +x: north is that angle to the left of x."""
    angle = mission.orchard.origin.heading
    north = np.array([np.cos(angle), np.sin(angle)])
    size = 0.03 * span
    centre = np.array([high[0] - 0.07 * span, low[1] + 0.055 * span])
    needle = _arrow(centre, north, size, "#263238")
    x, y = centre + north * size * 1.6
    return [needle, Label(float(x), float(y) - 0.008 * span, "N", size=0.9)]
