"""The picture of one or several flights: route from above, height, speeds, yaw rate over time.

After Liu 2024, Figs. 15 and 16. Colours are Okabe and Ito's, told apart by the colour-blind.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Sheet
from matplotlib.patches import Circle

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.mission import Mission
from orchard_cli.model.world import Pole

from . import signals
from .aligned import on_route, place_at
from .flight import Flight, names

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
_GREEN, _GREY, _INK = "#C9DDBF", "#8A8A8A", "#222222"
_TREE_RADIUS = 1.0  # m: surveys measure no canopy width, so trees are drawn as discs of this size


@dataclass(frozen=True, slots=True)
class _Pen:
    colour: str
    width: float


def save(
    path: Path, mission: Mission, flights: Sequence[Flight], poles: Sequence[Pole] = ()
) -> None:
    """Draw and write a PNG, SVG or PDF by the file's suffix. Raises InputError when it cannot."""
    if path.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise InputError(Fault(str(path), "no kind of picture", "name a .png, .svg or .pdf"))
    sheet = draw(mission, flights, poles)
    try:
        sheet.savefig(path, dpi=130, metadata={"Date": None} if path.suffix == ".svg" else None)
    except OSError as error:
        fault = Fault(str(path), f"cannot be written: {error.strerror}", "name another file")
        raise InputError(fault) from None


def draw(mission: Mission, flights: Sequence[Flight], poles: Sequence[Pole] = ()) -> Sheet:
    """The sheet: the route on the left, the curves over time on the right."""
    sheet = Sheet(figsize=(15.0, 9.0), layout="constrained")
    FigureCanvasAgg(sheet)
    grid = sheet.add_gridspec(5, 2, width_ratios=(1.15, 1.0))
    above = sheet.add_subplot(grid[:, 0])
    curves = [sheet.add_subplot(grid[0, 1])]
    curves += [sheet.add_subplot(grid[i, 1], sharex=curves[0]) for i in range(1, 5)]
    _orchard(above, mission, poles)
    labels = [
        name if name == flight.log.system else f"{name}: {flight.log.file}"
        for name, flight in zip(names(flights), flights, strict=True)
    ]
    for i, flight in enumerate(flights):  # the first is widest, so that the others do not hide it
        pen = _Pen(COLOURS[i % len(COLOURS)], max(1.0, 2.4 - 0.7 * i) if len(flights) > 1 else 1.6)
        _route(above, flight, labels[i], pen)
        _curves(curves, flight, pen, by_time=len(flights) == 1)
    if len(flights) == 1:
        _shade(curves, flights[0])
    _finish_above(above, mission)
    _finish_curves(curves, mission, by_time=len(flights) == 1)
    return sheet


def _orchard(axes: Axes, mission: Mission, poles: Sequence[Pole]) -> None:
    trees = np.vstack([row.trunks_site for row in mission.orchard.rows])
    for x, y in trees:
        axes.add_patch(Circle((x, y), _TREE_RADIUS, color=_GREEN, linewidth=0, zorder=1))
    axes.plot([], [], "o", color=_GREEN, markersize=9, label="trees")
    for i, pole in enumerate(poles):
        axes.add_patch(Circle((pole.x, pole.y), pole.radius, color=_INK, zorder=4))
        label = "poles" if i == 0 else None
        axes.plot(pole.x, pole.y, "s", color=_INK, markersize=6, zorder=4, label=label)
    for ring in (mission.orchard.fence_site, *mission.orchard.keep_outs_site):
        if len(ring):
            axes.plot(*np.vstack([ring, ring[:1]]).T, color=_GREY, linewidth=1.0, zorder=1)
    x, y, _ = np.asarray(mission.waypoints_site).T
    axes.plot(x, y, color=_GREY, linestyle=(0, (5, 3)), linewidth=1.3, zorder=2, label="planned Π")
    axes.plot(x, y, "o", color=_GREY, markersize=3, zorder=2)


def _route(axes: Axes, flight: Flight, label: str, pen: _Pen) -> None:
    x, y, _ = flight.log.odometry.positions_site.T
    axes.plot(x, y, color=pen.colour, linewidth=pen.width, zorder=3, label=label)
    for number, avoidance in enumerate(flight.metrics.avoidances, 1):
        axes.annotate(
            str(number),
            (float(avoidance.peak_site[0]), float(avoidance.peak_site[1])),
            xytext=(9, 9),
            textcoords="offset points",
            color="white",
            fontsize=8,
            ha="center",
            va="center",
            zorder=6,
            bbox={"boxstyle": "circle,pad=0.25", "facecolor": pen.colour, "edgecolor": "white"},
            arrowprops={"arrowstyle": "-", "color": pen.colour, "linewidth": 0.8},
        )


def _finish_above(axes: Axes, mission: Mission) -> None:
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title(f"{mission.name}: from above, avoidances numbered", loc="left", fontsize=11)
    axes.set_xlabel("x along the rows (m)")
    axes.set_ylabel("y across the rows (m)")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.07), ncols=4, frameon=False)
    _plain(axes)


def _curves(curves: Sequence[Axes], flight: Flight, pen: _Pen, by_time: bool) -> None:
    track = flight.log.odometry
    if not len(track.times):
        return
    keep = slice(None) if by_time else on_route(flight, track.times)
    at = track.times[keep] - flight.begin if by_time else place_at(flight, track.times[keep])
    style: dict[str, Any] = {"color": pen.colour, "linewidth": 0.75 * pen.width}
    height, *speeds, turn = curves
    height.plot(at, track.positions_site[keep, 2], **style)
    for i, axes in enumerate(speeds):
        axes.plot(at, track.velocities_site[keep, i], **style)
    times, rates = signals.yaw_rates(track)
    turn.plot(at, np.interp(track.times[keep], times, rates), **style)


def _shade(curves: Sequence[Axes], flight: Flight) -> None:
    for avoidance in flight.metrics.avoidances:
        begin, end = avoidance.start - flight.begin, avoidance.end - flight.begin
        for i, axes in enumerate(curves):
            label = "avoidance" if i == 0 and avoidance is flight.metrics.avoidances[0] else None
            axes.axvspan(begin, end, color="#EEE3C8", linewidth=0, zorder=0, label=label)


def _finish_curves(curves: Sequence[Axes], mission: Mission, by_time: bool) -> None:
    titles = (
        "height z (m); planned height dashed",
        "speed along x (m/s)",
        "speed along y (m/s)",
        "speed along z (m/s)",
        "yaw rate (rad/s); the mission's limit dotted",
    )
    for axes, title in zip(curves, titles, strict=True):
        axes.set_title(title, loc="left", fontsize=9)
        _plain(axes)
        axes.tick_params(labelsize=8, labelbottom=axes is curves[-1])
    for axes, middle in ((curves[0], mission.flight_height_site), (curves[3], 0.0)):
        low, high = axes.get_ylim()  # a steady flight shall look steady
        axes.set_ylim(min(low, middle - 0.5), max(high, middle + 0.5))
    curves[0].axhline(mission.flight_height_site, color=_GREY, linestyle=(0, (5, 3)), linewidth=1)
    if curves[0].get_legend_handles_labels()[0]:
        curves[0].legend(loc="lower center", fontsize=8, frameon=False)
    for limit in (-mission.limits.yaw_rate, mission.limits.yaw_rate):
        curves[-1].axhline(limit, color=_GREY, linestyle=":", linewidth=1)
    alone, several = "time since the first waypoint (s)", "place along the planned route (m)"
    curves[-1].set_xlabel(alone if by_time else several)


def _plain(axes: Axes) -> None:
    axes.grid(visible=True, color="#E6E6E6", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
