"""Pieces that plotly charts are made of: lines, axes, layouts, thinning. Plain JSON values."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchard_cli.model.arrays import Array

from ..overview import COLOURS

Chart = dict[str, Any]

POINTS = 1500  # of a curve: more cannot be seen
INK, GREY, LEAF = "#1f2933", "#6b7785", "#cfe3c4"
_GRID = "#e6e9ed"
_DASHES = ("solid", "dash", "dot", "dashdot")
_FONT = {"family": "system-ui, sans-serif", "size": 12, "color": INK}


def line(x: Any, y: Any, name: str, colour: str, dash: str = "solid", width: float = 2.0) -> Chart:
    """A curve in the plane."""
    return {
        "type": "scatter", "mode": "lines", "name": name, "x": rounded(x), "y": rounded(y, 4),
        "line": {"color": colour, "width": width, "dash": dash},
    }  # fmt: skip


def line3(
    x: Any, y: Any, z: Any, name: str, colour: str, width: float, dash: str = "solid"
) -> Chart:
    """A curve in space."""
    return {
        "type": "scatter3d", "mode": "lines", "name": name,
        "x": rounded(x), "y": rounded(y), "z": rounded(z),
        "line": {"color": colour, "width": width, "dash": dash},
        "hovertemplate": "x %{x:.2f} m, y %{y:.2f} m, z %{z:.2f} m",
    }  # fmt: skip


def layout(legend: bool) -> Chart:
    """What all charts share."""
    return {
        "autosize": True, "font": _FONT, "showlegend": legend, "paper_bgcolor": "white",
        "plot_bgcolor": "white", "margin": {"l": 48, "r": 12, "t": 8, "b": 40},
        "legend": {"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0},
        "hoverlabel": {"font": {"size": 12}},
    }  # fmt: skip


def axis(title: str) -> Chart:
    """One axis with its title."""
    return {
        "title": {"text": title, "standoff": 6}, "gridcolor": _GRID, "zerolinecolor": "#c9cfd6",
        "linecolor": "#c9cfd6", "automargin": True,
    }  # fmt: skip


def colour(i: int) -> str:
    """Of the i-th flight."""
    return COLOURS[i % len(COLOURS)]


def dash(i: int) -> str:
    """Of the i-th flight: told apart without colour."""
    return _DASHES[i % len(_DASHES)]


def every(count: int) -> slice:
    """A step that leaves about POINTS samples."""
    return slice(None, None, max(1, count // POINTS))


def extremes(values: Array) -> np.ndarray[Any, Any]:
    """Indices that keep the smallest and largest of each short stretch: no peak is lost."""
    step = max(1, 2 * len(values) // POINTS)
    if step < 3:
        return np.arange(len(values))
    whole = len(values) // step * step
    parts = np.asarray(values[:whole]).reshape(-1, step)
    base = np.arange(len(parts)) * step
    picked = np.concatenate(
        [base + parts.argmin(axis=1), base + parts.argmax(axis=1), [len(values) - 1]]
    )
    return np.unique(picked)


def rounded(values: Any, digits: int = 3) -> list[Any]:
    """Plain numbers; what is not finite is null."""
    array = np.asarray(values, dtype=np.float64)
    return [round(v, digits) if np.isfinite(v) else None for v in array.tolist()]
