"""Sketches as PNG, drawn by matplotlib."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from .sketch import Disc, Label, Path, Shape, Sketch, Style
from .svg import MARK

_WIDTH = 12.0  # inches
_DPI = 100
_POINTS = 72 / 96  # a pixel of the SVG in points
_LETTERS = 13.0  # points


def write(sketch: Sketch, title: str) -> bytes:
    """The bytes of a picture."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    size = sketch.high - sketch.low
    figure = Figure(figsize=(_WIDTH, float(_WIDTH * size[1] / size[0])), dpi=_DPI)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(sketch.low[0], sketch.high[0])
    axes.set_ylim(sketch.low[1], sketch.high[1])
    metre = _WIDTH * 72 / float(size[0])  # in points
    for order, shape in enumerate(sketch.shapes):
        _draw(axes, shape, metre, order)
    out = io.BytesIO()
    figure.savefig(out, format="png", metadata={"Title": title, "Software": MARK})
    return out.getvalue()


def _draw(axes: Any, shape: Shape, metre: float, order: int) -> None:
    from matplotlib import patheffects
    from matplotlib.patches import Circle, Polygon

    if isinstance(shape, Path):
        if shape.closed:
            axes.add_patch(Polygon(shape.points, zorder=order, **_paint(shape.style, metre)))
            return
        style = shape.style
        width = style.width * (metre if style.metric else _POINTS)
        points = np.asarray(shape.points)
        axes.plot(
            *points.T, color=style.stroke, linewidth=width, alpha=style.opacity, zorder=order,
            linestyle=_dashes(style), solid_capstyle="butt",
        )  # fmt: skip
    elif isinstance(shape, Disc):
        at = (shape.x, shape.y)
        axes.add_patch(Circle(at, shape.radius, zorder=order, **_paint(shape.style, metre)))
    elif isinstance(shape, Label):
        sides = {"middle": "center", "end": "right", "start": "left"}
        halo = [patheffects.withStroke(linewidth=2.5, foreground="white", alpha=0.85)]
        axes.text(
            shape.x, shape.y, shape.text, color=shape.colour, ha=sides[shape.anchor],
            va="baseline", fontsize=_LETTERS * shape.size, weight="bold", zorder=order,
            path_effects=halo if shape.halo else [], parse_math=False,
        )  # fmt: skip


def _paint(style: Style, metre: float) -> dict[str, Any]:
    return {
        "facecolor": style.fill,
        "edgecolor": style.stroke,
        "linewidth": style.width * (metre if style.metric else _POINTS),
        "linestyle": _dashes(style),
        "alpha": style.opacity,
    }


def _dashes(style: Style) -> Any:
    return (0, style.dash) if style.dash else "solid"
