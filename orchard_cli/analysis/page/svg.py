"""Small drawings of the ground as SVG text: crisp at every width and in print."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

import numpy as np
from numpy.typing import ArrayLike
from shapely import get_parts
from shapely.geometry.base import BaseGeometry

from orchard_cli.model.arrays import Points

PIXELS = 640.0  # width of the drawing's own coordinates

INK, GREY, LEAF, CELL = "#1f2933", "#6b7785", "#cfe3c4", "#e0761a"


class Ground:
    """A piece of the site, x to the right and y up, drawn at one scale."""

    def __init__(self, low: ArrayLike, high: ArrayLike, title: str) -> None:
        """`low`, `high`: (2,) m, corners of the piece."""
        self._low, self._high = np.asarray(low, float)[:2], np.asarray(high, float)[:2]
        size = np.maximum(self._high - self._low, 1e-6)
        self._scale = PIXELS / size[0]
        self._height = float(size[1] * self._scale)
        self._title = title
        self._parts: list[str] = []

    def _at(self, points: ArrayLike) -> Points:
        moved: Points = (np.atleast_2d(np.asarray(points, float))[:, :2] - self._low) * self._scale
        moved[:, 1] = self._height - moved[:, 1]
        return moved

    def line(self, points: ArrayLike, colour: str, width: float = 2.0, dash: str = "") -> None:
        """A polyline; `width` and `dash` in the drawing's pixels."""
        if len(np.atleast_2d(points)) < 2:
            return
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in self._at(points))
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        self._parts.append(
            f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="{width}"'
            f' stroke-linejoin="round" stroke-linecap="round"{dashed}/>'
        )

    def disc(self, centre: ArrayLike, radius: float, fill: str, least: float = 0.0) -> None:
        """A disc of a radius in m, at least `least` pixels."""
        ((x, y),) = self._at(centre)
        r = max(radius * self._scale, least)
        self._parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r:.1f}" fill="{fill}"/>')

    def squares(self, centres: ArrayLike, edge: float, fill: str) -> None:
        """Squares of an edge in m."""
        side = edge * self._scale
        path = "".join(
            f"M{x - side / 2:.1f} {y - side / 2:.1f}h{side:.1f}v{side:.1f}h-{side:.1f}z"
            for x, y in self._at(centres)
        )
        self._parts.append(f'<path d="{path}" fill="{fill}"/>')

    def area(self, shape: BaseGeometry, fill: str) -> None:
        """Polygons with their holes."""
        rings = [
            ring
            for polygon in get_parts(shape)
            if polygon.geom_type == "Polygon" and not polygon.is_empty
            for ring in (polygon.exterior, *polygon.interiors)
        ]
        path = "".join(
            "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in self._at(ring.coords)) + "z"
            for ring in rings
        )
        if path:
            self._parts.append(f'<path d="{path}" fill="{fill}" fill-rule="evenodd"/>')

    def craft(self, position: ArrayLike, heading: float, colour: str) -> None:
        """An arrow head where the vehicle is, pointing where its nose points."""
        ((x, y),) = self._at(position)
        tip = [(14, 0), (-9, 8), (-5, 0), (-9, -8)]
        c, s = np.cos(-heading), np.sin(-heading)
        path = " ".join(f"{x + c * a - s * b:.1f},{y + s * a + c * b:.1f}" for a, b in tip)
        self._parts.append(
            f'<polygon points="{path}" fill="{colour}" stroke="white" stroke-width="1.5"/>'
        )

    def label(self, position: ArrayLike, text: str, dx: float = 0.0, dy: float = 0.0) -> None:
        """A word beside a place; `dx`, `dy` in pixels."""
        ((x, y),) = self._at(position)
        self._text(x + dx, y + dy, text)

    def _text(self, x: float, y: float, text: str, anchor: str = "start") -> None:
        self._parts.append(
            f'<text x="{x:.1f}" y="{y:.1f}" font-size="18" fill="{INK}" text-anchor="{anchor}"'
            f' stroke="white" stroke-width="4" paint-order="stroke">{escape(text)}</text>'
        )

    def scale_bar(self) -> None:
        """A bar of 1, 2, 5, 10 ... m in the lower left corner."""
        fifth = (self._high - self._low)[0] / 5
        length = max((v for v in _lengths() if v <= fifth), default=1.0)
        y, x, pixels = self._height - 14, 14.0, length * self._scale
        self._parts.append(
            f'<path d="M{x} {y - 5}v10M{x} {y}h{pixels:.1f}M{x + pixels:.1f} {y - 5}v10"'
            f' stroke="{INK}" stroke-width="2" fill="none"/>'
        )
        self._text(x + pixels + 8, y + 6, f"{length:g} m")

    def text(self) -> str:
        """The SVG element."""
        return (
            f'<svg viewBox="0 0 {PIXELS:.0f} {self._height:.0f}" role="img"'
            f' aria-label="{escape(self._title)}" font-family="inherit">'
            f"<title>{escape(self._title)}</title>{''.join(self._parts)}</svg>"
        )


def _lengths() -> Iterable[float]:
    return (m * 10.0**e for e in range(-1, 4) for m in (1, 2, 5))
