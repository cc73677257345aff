"""Every metric of docs/metrics.md, from a read log and its mission. Pure."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable

import numpy as np

from orchard_cli.model.arrays import Array
from orchard_cli.model.flown import FlownLog
from orchard_cli.model.mission import Mission

from . import signals
from .contact import contacts_figure, until_contact
from .coverage import coverage
from .detours import avoidances, nearest
from .figures import Avoidance, Clearances, Figure, Metrics, Unknown
from .lines import Line, planned, spline_points
from .mapped import map_clearance
from .route import Route, route
from .stream import setpoint_jitter, waypoints_missed

GAP = 1.0  # s without odometry that the reader is told of

Figures = dict[str, Figure]


def measure(log: FlownLog, mission: Mission, clearances: Clearances | Unknown) -> Metrics:
    """All metrics of one flight.

    `clearances`: distances to the simulated world along the true path; Unknown says why there
    are none, and then the map that was built in flight is used if the log holds it.
    """
    log, clearances = until_contact(log, clearances)
    flown = route(log, mission)
    found: tuple[Avoidance, ...] = ()
    figures: Figures = {}
    if isinstance(flown, Unknown):
        figures |= dict.fromkeys(_ROUTE_NAMES, flown)
    else:
        found = avoidances(log, mission, flown, clearances)
        figures |= _route_figures(log, mission, flown, found)
    figures |= _clearance_figures(log, mission, flown, clearances)
    figures["contacts"] = contacts_figure(log)
    figures |= _coverage_figures(log, mission)
    figures |= _planner_figures(log)
    figures |= _battery_figures(log)
    figures["setpoint_jitter_p99_ms"] = setpoint_jitter(log.commands.times)
    figures["liquid_used_l"] = _liquid(log)
    start, end = (None, None) if isinstance(flown, Unknown) else (flown.start, flown.end)
    notes = (*log.notes, *_notes(log, flown))
    return Metrics(figures, found, start, end, notes, log.contacts or ())


_DEVIATIONS = ("mean", "rms", "p95", "max")
_ROUTE_NAMES: tuple[str, ...] = (
    "distance_m",
    "duration_s",
    *(f"deviation_{kind}_m" for kind in _DEVIATIONS),
    *(f"deviation_spline_{kind}_m" for kind in _DEVIATIONS),
    *(f"height_error_{kind}_m" for kind in _DEVIATIONS),
    "avoidances",
    "avoidance_peak_mean_m",
    "altitude_drop_max_m",
    "speed_max_m_s",
    *(f"speed_max_{axis}_m_s" for axis in "xyz"),
    "acceleration_max_m_s2",
    "acceleration_planned_max_m_s2",
    "yaw_rate_max_rad_s",
    "yaw_rate_mean_rad_s",
    "waypoints_missed",
)


def _route_figures(
    log: FlownLog, mission: Mission, flown: Route, found: tuple[Avoidance, ...]
) -> Figures:
    track, times = flown.track, flown.track.times
    unfinished = Unknown("the last waypoint was not reached")
    pi = planned(mission).offset(track.positions_site)
    spline = Line(spline_points(mission.spline)).offset(track.positions_site)
    none = Unknown("there was no avoidance")
    speeds = np.abs(track.velocities_site)
    times_a, accelerations = signals.accelerations(log.odometry)
    on_route = (times_a >= flown.start) & (times_a <= flown.end)
    times_y, yaw_rates = signals.yaw_rates(track)
    figures: Figures = {
        "distance_m": signals.path_length(track) if flown.completed else unfinished,
        "duration_s": flown.end - flown.start if flown.completed else unfinished,
        **_spread("deviation", times, pi.distance),
        **_spread("deviation_spline", times, spline.distance),
        **_spread("height_error", times, np.abs(track.positions_site[:, 2] - pi.height)),
        "avoidances": len(found),
        "avoidance_peak_mean_m": float(np.mean([a.peak_m for a in found])) if found else none,
        "altitude_drop_max_m": max(a.altitude_drop_m for a in found) if found else none,
        "speed_max_m_s": float(np.linalg.norm(track.velocities_site, axis=1).max()),
        **{f"speed_max_{a}_m_s": float(speeds[:, i].max()) for i, a in enumerate("xyz")},
        "acceleration_max_m_s2": float(accelerations[on_route].max()),
        "acceleration_planned_max_m_s2": _planned_acceleration(log, flown),
        "yaw_rate_max_rad_s": float(np.abs(yaw_rates).max()),
        "yaw_rate_mean_rad_s": signals.mean(times_y, np.abs(yaw_rates)),
        "waypoints_missed": waypoints_missed(track, mission) if flown.completed else unfinished,
    }
    return figures


def _spread(name: str, times: Array, values: Array) -> Figures:
    measures: dict[str, Callable[[Array, Array], float]] = {
        "mean": signals.mean,
        "rms": signals.rms,
        "p95": signals.percentile_95,
        "max": lambda _, v: float(v.max()),
    }
    return {f"{name}_{kind}_m": measures[kind](times, values) for kind in _DEVIATIONS}


def _planned_acceleration(log: FlownLog, flown: Route) -> Figure:
    times = log.commands.times
    inside = (times >= flown.start) & (times <= flown.end)
    sizes = np.linalg.norm(log.commands.accelerations_site[inside], axis=1)
    if not np.isfinite(sizes).any():
        return Unknown("no acceleration was commanded")
    return float(np.nanmax(sizes))


def _clearance_figures(
    log: FlownLog, mission: Mission, flown: Route | Unknown, clearances: Clearances | Unknown
) -> Figures:
    if isinstance(clearances, Unknown):
        return {
            "clearance_min_m": map_clearance(log, mission, flown) if log.maps else clearances,
            "clearance_trees_min_m": clearances,
        }
    trees = clearances.trees
    none = Unknown("there are no trees in the world" if len(trees) else "no positions")
    return {
        "clearance_min_m": nearest(clearances),
        "clearance_trees_min_m": float(trees.min()) if np.isfinite(trees).any() else none,
    }


def _coverage_figures(log: FlownLog, mission: Mission) -> Figures:
    found = coverage(log, mission)
    names = ("coverage_percent", "overlap_percent", "missed_strip_m")
    if isinstance(found, Unknown):
        return dict.fromkeys(names, found)
    return dict(
        zip(names, (found.percent, found.overlap_percent, found.missed_strip_m), strict=True)
    )


def _planner_figures(log: FlownLog) -> Figures:
    if not log.planner:
        silent = Unknown("the log holds no planner cycles")
        return {"replans": silent, "replan_failures": silent}
    decisions = [record.decision for record in log.planner]
    figures: Figures = {
        "replans": decisions.count("avoid"),
        "replan_failures": decisions.count("stop"),
    }
    stages: defaultdict[str, list[float]] = defaultdict(list)
    for record in log.planner:
        for stage, milliseconds in record.stages_ms.items():
            stages[stage].append(milliseconds)
    for stage, took in stages.items():
        figures[f"latency_{stage}_median_ms"] = float(np.median(took))
        figures[f"latency_{stage}_p99_ms"] = float(np.quantile(took, 0.99))
        figures[f"latency_{stage}_max_ms"] = max(took)
    return figures


def _battery_figures(log: FlownLog) -> Figures:
    known = log.battery_shares[np.isfinite(log.battery_shares)]
    if len(known) < 2:
        unknown = Unknown("the battery's level is not in the log")
        return {"battery_used_percent": unknown, "battery_left_percent": unknown}
    return {
        "battery_used_percent": 100.0 * float(known[0] - known[-1]),
        "battery_left_percent": 100.0 * float(known[-1]),
    }


def _liquid(log: FlownLog) -> Figure:
    used = [record.used for record in log.spray if record.used is not None]
    return max(used) if used else Unknown("the log holds no tank level")


def _notes(log: FlownLog, flown: Route | Unknown) -> list[str]:
    notes = [f"touched {touched}" for touched in log.contacts or ()]
    if not isinstance(flown, Unknown) and not flown.completed:
        notes.append("the last waypoint was not reached: deviations are up to the route's end")
    gaps = np.diff(log.odometry.times)
    if len(gaps) and gaps.max() > GAP:
        notes.append(f"the odometry has a gap of {gaps.max():.1f} s")
    if log.truth is not None:
        notes.append("simulated: clearance is from the true path, the rest from the estimated one")
    notes += [line.text for line in log.lines if line.room == "flightlog"][-1:]
    return notes
