"""The charts of the page as plotly's own JSON: routes from above and in 3D, curves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from orchard_cli.model.world import World

from .. import signals
from ..aligned import on_route, place_at
from ..figures import Unknown
from ..flight import Flight
from ..lines import planned
from .chart_parts import (
    GREY,
    INK,
    LEAF,
    Chart,
    axis,
    colour,
    dash,
    every,
    extremes,
    layout,
    line,
    line3,
    rounded,
)
from .maps import TREE_RADIUS


def above(flights: Sequence[Flight], names: Sequence[str]) -> Chart:
    """All routes over the first one's orchard, avoidances numbered."""
    first = flights[0]
    x, y, _ = first.mission.waypoints_site.T
    traces = [
        line(x, y, "planned Π", GREY, dash="dash", width=1.5),
        *_poles(first.world),
    ]
    for i, (flight, name) in enumerate(zip(flights, names, strict=True)):
        keep = every(len(flight.log.odometry.times))
        track = flight.log.odometry
        x, y = track.positions_site[keep, :2].T
        trace = line(x, y, name, colour(i), dash(i), 2.2)
        trace["customdata"] = rounded(track.times[keep] - flight.begin)
        trace["hovertemplate"] = "x %{x:.2f} m, y %{y:.2f} m, %{customdata:.1f} s"
        traces.append(trace)
        traces += _numbers(flight, i)
    sheet = layout(legend=True)
    low, high = first.mission.waypoints_site[:, 0].min(), first.mission.waypoints_site[:, 0].max()
    reach = [float(low) - 6.0, float(high) + 6.0]  # take-off and landing lie beyond the rows
    sheet["xaxis"] = {**axis("x along the rows (m)"), "range": reach}
    sheet["yaxis"] = {**axis("y across the rows (m)"), "scaleanchor": "x"}
    sheet["shapes"] = [
        {
            "type": "circle", "layer": "below", "fillcolor": LEAF, "line": {"width": 0},
            "x0": x - r, "x1": x + r, "y0": y - r, "y1": y + r,
        }
        for x, y, r in _trees(first)
    ]  # fmt: skip
    return {"data": traces, "layout": sheet}


def space(flights: Sequence[Flight], names: Sequence[str]) -> Chart:
    """The same in three dimensions, to turn by hand."""
    first = flights[0]
    trees = np.array([(x, y) for x, y, _ in _trees(first)]).reshape(-1, 2)
    top = first.mission.orchard.canopy_top_site
    x, y, z = first.mission.waypoints_site.T
    traces: list[Chart] = [
        {
            "type": "scatter3d", "mode": "markers", "name": "canopy tops", "hoverinfo": "skip",
            "x": rounded(trees[:, 0]), "y": rounded(trees[:, 1]), "z": [round(top, 2)] * len(trees),
            "marker": {"size": 5, "color": "#7fae6b"},
        },
        line3(x, y, z, "planned Π", GREY, 3, "dash"),
    ]  # fmt: skip
    for pole in first.world.poles if first.world else ():
        traces.append(
            {**line3([pole.x] * 2, [pole.y] * 2, [pole.ground, pole.ground + pole.height],
                      "poles", INK, 8), "legendgroup": "poles",
             "showlegend": pole is first.world.poles[0] if first.world else False}
        )  # fmt: skip
    for i, (flight, name) in enumerate(zip(flights, names, strict=True)):
        points = flight.log.odometry.positions_site
        x, y, z = points[every(len(points))].T
        traces.append(line3(x, y, z, name, colour(i), 5))
    sheet = layout(legend=True)
    size = np.ptp(first.mission.waypoints_site, axis=0)
    wide, deep, _ = size / max(float(size.max()), 1.0)
    sheet["scene"] = {
        "aspectmode": "manual",
        "aspectratio": {"x": 1.6 * wide, "y": 1.6 * max(deep, 0.2), "z": 0.35},
        "xaxis": {"title": {"text": "x (m)"}}, "yaxis": {"title": {"text": "y (m)"}},
        "zaxis": {"title": {"text": "z (m)"}, "nticks": 4},
        "camera": {
            "eye": {"x": -0.62, "y": -1.2, "z": 0.72}, "center": {"x": 0, "y": 0, "z": -0.12},
        },
    }  # fmt: skip
    sheet["margin"] = {"l": 0, "r": 0, "t": 0, "b": 0}
    return {"data": traces, "layout": sheet}


def curves(flights: Sequence[Flight], names: Sequence[str]) -> Chart:
    """Height, speeds, yaw rate, clearance (and deviation): over time, or over place for several."""
    alone = len(flights) == 1
    panels = _PANELS if alone else ("deviation", *_PANELS)
    sheet = layout(legend=not alone)
    sheet["shapes"], sheet["annotations"] = [], []
    traces = []
    for row, panel in enumerate(panels):
        which = "" if row == 0 else str(row + 1)
        high = 1.0 - row / len(panels)
        low = high - 1.0 / len(panels) + 0.045
        sheet[f"yaxis{which}"] = {**axis(""), "domain": [low, high - 0.012], "anchor": "x"}
        sheet["annotations"].append(_title(_TITLES[panel], high))
        for i, flight in enumerate(flights):
            at, values = _curve(flight, panel, alone)
            trace = line(at, values, names[i], colour(i), dash(i), 1.4)
            traces.append({**trace, "yaxis": f"y{which}", "showlegend": row == 0,
                           "legendgroup": names[i], "hovertemplate": "%{y:.3f}"})  # fmt: skip
        sheet["shapes"] += _limits(flights[0], panel, f"y{which}")
    if alone:
        sheet["shapes"] += [
            _shade(one.start, one.end, flights[0], f"y{row + 1 if row else ''} domain")
            for one in flights[0].metrics.avoidances
            for row in range(len(panels))
        ]
    where = "time since the first waypoint (s)" if alone else "place along the planned route (m)"
    sheet["xaxis"] = {**axis(where), "anchor": f"y{len(panels)}"}
    sheet["hovermode"] = "x"
    return {"data": traces, "layout": sheet}


_PANELS = ("height", "x", "y", "z", "yaw", "clearance")
_TITLES = {
    "deviation": "distance from the planned Π (m)",
    "height": "height z (m), planned dashed",
    "x": "speed along x, along the rows (m/s)",
    "y": "speed along y, across the rows (m/s)",
    "z": "speed along z, up (m/s)",
    "yaw": "yaw rate (rad/s), the mission's limit dotted",
    "clearance": "clearance (m), drawn up to 8; limit dotted",
}
_SEEN = 8.0  # m: farther obstacles do not matter


def _curve(flight: Flight, panel: str, by_time: bool) -> tuple[list[Any], list[Any]]:
    track = flight.log.odometry
    times, values = track.times, np.empty(0)
    if panel == "height":
        values = track.positions_site[:, 2]
    elif panel == "yaw":
        times, values = signals.yaw_rates(track)
    elif panel == "deviation":
        values = planned(flight.mission).offset(track.positions_site).distance
    elif panel == "clearance":
        if isinstance(flight.clearances, Unknown):
            return [], []
        times = flight.clearances.times
        values = np.minimum(flight.clearances.obstacles, _SEEN)
    else:
        values = track.velocities_site[:, "xyz".index(panel)]
    if not by_time:
        inside = on_route(flight, times)
        times, values = times[inside], values[inside]
    keep = extremes(values)
    times, values = times[keep], values[keep]
    at = times - flight.begin if by_time else place_at(flight, times)
    return rounded(at), rounded(values, 4)


def _limits(flight: Flight, panel: str, axis: str) -> list[Chart]:
    limits = flight.mission.limits
    levels = {
        "height": [(flight.mission.flight_height_site, "dash")],
        "yaw": [(limits.yaw_rate, "dot"), (-limits.yaw_rate, "dot")],
        "clearance": [(limits.clearance, "dot")],
    }
    return [
        {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "yref": axis, "y0": y, "y1": y,
         "line": {"color": GREY, "width": 1.2, "dash": dash}}
        for y, dash in levels.get(panel, [])
    ]  # fmt: skip


def _shade(start: float, end: float, flight: Flight, where: str) -> Chart:
    return {
        "type": "rect", "layer": "below", "xref": "x", "yref": where, "y0": 0, "y1": 1,
        "x0": start - flight.begin, "x1": end - flight.begin,
        "fillcolor": "#f3e6c4", "line": {"width": 0},
    }  # fmt: skip


def _title(text: str, high: float) -> Chart:
    return {
        "text": text, "xref": "paper", "yref": "paper", "x": 0, "y": high - 0.012,
        "xanchor": "left", "yanchor": "bottom", "showarrow": False, "font": {"size": 12},
    }  # fmt: skip


def _numbers(flight: Flight, i: int) -> list[Chart]:
    found = flight.metrics.avoidances
    if not found:
        return []
    places_xy = np.array([one.peak_site for one in found])
    return [
        {
            "type": "scatter", "mode": "markers+text", "showlegend": False,
            "x": rounded(places_xy[:, 0]), "y": rounded(places_xy[:, 1]),
            "text": [str(n) for n in range(1, len(found) + 1)],
            "textfont": {"color": "white", "size": 11},
            "marker": {"size": 18, "color": colour(i), "line": {"color": "white", "width": 1.5}},
            "hovertemplate": "avoidance %{text}<extra></extra>",
        }
    ]  # fmt: skip


def _poles(world: World | None) -> list[Chart]:
    if world is None or not world.poles:
        return []
    return [
        {
            "type": "scatter", "mode": "markers", "name": "poles",
            "x": [pole.x for pole in world.poles], "y": [pole.y for pole in world.poles],
            "marker": {"symbol": "square", "size": 8, "color": INK},
            "hovertemplate": "x %{x:.2f} m, y %{y:.2f} m",
        }
    ]  # fmt: skip


def _trees(flight: Flight) -> list[tuple[float, float, float]]:
    if flight.world is not None:
        return [(tree.x, tree.y, tree.canopy_radius) for tree in flight.world.trees]
    rows = flight.mission.orchard.rows
    return [(float(x), float(y), TREE_RADIUS) for row in rows for x, y in row.trunks_site]
