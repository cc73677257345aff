"""Sketches as SVG. Lines keep their width in pixels at any size of the picture."""

from __future__ import annotations

import numpy as np
from lxml import etree
from lxml.builder import ElementMaker

from .sketch import Disc, Label, Path, Shape, Sketch, Style
from .xml import rendered

SVG = "http://www.w3.org/2000/svg"
MARK = "orchard plan preview"  # by which a preview is known to be one
_S = ElementMaker(namespace=SVG, nsmap={None: SVG})
_LETTERS = 0.021  # height of a label over the picture's width


def drawing(sketch: Sketch, title: str, width_px: int | None = None) -> etree._Element:
    """The <svg> of a sketch; without a width it fills what it stands in."""
    size = sketch.high - sketch.low
    box = [sketch.low[0], -sketch.high[1], *size]
    root = _S.svg(
        _S.title(title),
        viewBox=" ".join(_n(v) for v in box),
        role="img",
        **{"font-family": "system-ui, sans-serif"},
    )
    root.append(etree.Comment(f" {MARK} "))
    if width_px is not None:
        root.set("width", str(width_px))
        root.set("height", str(round(width_px * size[1] / size[0])))
    letters = _LETTERS * float(size[0])
    for shape in sketch.shapes:
        root.append(_element(shape, letters))
    return root


def write(sketch: Sketch, title: str) -> bytes:
    """A picture file."""
    return rendered(drawing(sketch, title, 1200))


def _n(value: float) -> str:
    return f"{value:.3f}".rstrip("0").rstrip(".")


def _element(shape: Shape, letters: float) -> etree._Element:
    if isinstance(shape, Path):
        points = np.asarray(shape.points) * [1, -1]
        listed = " ".join(f"{_n(x)},{_n(y)}" for x, y in points)
        make = _S.polygon if shape.closed else _S.polyline
        return make(points=listed, **_paint(shape.style))
    if isinstance(shape, Disc):
        disc = _S.circle(cx=_n(shape.x), cy=_n(-shape.y), r=_n(shape.radius), **_paint(shape.style))
        if shape.title:
            disc.append(_S.title(shape.title))
        return disc
    return _word(shape, letters)


def _word(label: Label, letters: float) -> etree._Element:
    word = _S.text(
        label.text,
        x=_n(label.x),
        y=_n(-label.y),
        fill=label.colour,
        **{
            "text-anchor": label.anchor,
            "font-size": _n(letters * label.size),
            "font-weight": "600",
            "style": f"font-size:calc({_n(letters * label.size)}px*var(--letters,1))",
        },
    )
    if label.halo:
        word.set("paint-order", "stroke")
        word.set("stroke", "#ffffff")
        word.set("stroke-width", _n(letters * 0.22))
        word.set("stroke-opacity", "0.85")
    return word


def _paint(style: Style) -> dict[str, str]:
    paint = {"fill": style.fill}
    if style.stroke != "none":
        paint |= {"stroke": style.stroke, "stroke-width": _n(style.width)}
        paint["stroke-linejoin"] = "round"
        if not style.metric:
            paint["vector-effect"] = "non-scaling-stroke"
        if style.dash:
            paint["stroke-dasharray"] = " ".join(_n(d) for d in style.dash)
    if style.opacity < 1:
        paint["opacity"] = _n(style.opacity)
    return paint
