"""Figures and decisions in plain words: labels, units, numbers, sentences."""

from __future__ import annotations

import math

from ..figures import Figure, Unknown
from ..flight import Flight
from ..turns import Choice, Turn

_UNITS = (
    ("_m_s2", "m/s²"),
    ("_rad_s", "rad/s"),
    ("_m_s", "m/s"),
    ("_percent", "%"),
    ("_ms", "ms"),
    ("_m", "m"),
    ("_s", "s"),
    ("_l", "l"),
)
_LABELS = {
    "distance": "Distance flown",
    "duration": "Time on the route",
    "deviation_mean": "Deviation from the Π, mean",
    "deviation_rms": "Deviation from the Π, rms",
    "deviation_p95": "Deviation from the Π, not exceeded for 95 % of the time",
    "deviation_max": "Deviation from the Π, largest",
    "deviation_spline_mean": "Deviation from the B-spline, mean",
    "deviation_spline_rms": "Deviation from the B-spline, rms",
    "deviation_spline_p95": "Deviation from the B-spline, not exceeded for 95 % of the time",
    "deviation_spline_max": "Deviation from the B-spline, largest",
    "height_error_mean": "Height error, mean",
    "height_error_rms": "Height error, rms",
    "height_error_p95": "Height error, not exceeded for 95 % of the time",
    "height_error_max": "Height error, largest",
    "avoidances": "Avoidances",
    "avoidance_peak_mean": "Largest deviation in an avoidance, mean",
    "altitude_drop_max": "Height lost in an avoidance, largest",
    "speed_max": "Speed, largest",
    "speed_max_x": "Speed along x, largest",
    "speed_max_y": "Speed along y, largest",
    "speed_max_z": "Speed along z, largest",
    "acceleration_max": "Acceleration flown, largest",
    "acceleration_planned_max": "Acceleration commanded, largest",
    "yaw_rate_max": "Yaw rate, largest",
    "yaw_rate_mean": "Yaw rate, mean",
    "clearance_min": "Clearance to obstacles, smallest",
    "clearance_trees_min": "Clearance to trees, smallest",
    "contacts": "Contacts",
    "coverage": "Planned area that was sprayed",
    "overlap": "Sprayed area that was sprayed again",
    "missed_strip": "Longest stretch of a row that was missed",
    "replans": "Replans",
    "replan_failures": "Replans that found no way",
    "battery_used": "Battery used",
    "battery_left": "Battery left",
    "liquid_used": "Liquid used",
}


def unit(metric: str) -> str:
    """The unit that a metric's name ends in; empty for counts."""
    return next((unit for end, unit in _UNITS if metric.endswith(end)), "")


def label(metric: str) -> str:
    """What a metric is, for a reader; its own name where nothing better is known."""
    stem = next((metric.removesuffix(end) for end, _ in _UNITS if metric.endswith(end)), metric)
    return _LABELS.get(stem, metric)


def number(figure: Figure | None) -> str:
    """A figure without its unit: three digits that matter, "–" where it is not known."""
    if figure is None:
        return ""
    if isinstance(figure, Unknown) or not math.isfinite(figure):
        return "–"
    if isinstance(figure, int):
        return str(figure)
    size = abs(figure)
    return f"{figure:.1f}" if size >= 100 else f"{figure:.2f}" if size >= 1 else f"{figure:.3f}"


def signed(change: float) -> str:
    """A difference with its sign."""
    text = number(abs(change))
    sign = "" if text.strip("0.") == "" else "+" if change > 0 else "\u2212"
    return sign + text


def with_unit(metric: str, figure: Figure | None) -> str:
    """A figure and its unit, with a space that does not break."""
    text = number(figure)
    return f"{text}\u00a0{unit(metric)}" if unit(metric) and text not in ("", "–") else text


def clock(seconds: float) -> str:
    """12.3 s, or 3 min 51 s."""
    if seconds < 100:
        return f"{seconds:.1f}\u00a0s"
    return f"{int(seconds) // 60}\u00a0min {int(seconds) % 60:02d}\u00a0s"


def summary(flight: Flight) -> list[str]:
    """What happened, a sentence each."""
    figures = flight.metrics.figures
    said = []
    if flight.log.safety:
        last = flight.log.safety[-1]
        said.append(f"It ended so: {last.why}.")
    said.append(_route(figures["distance_m"], figures["duration_s"]))
    said += [f"It touched {touched}." for touched in flight.metrics.contacts]
    peaks = [one.peak_m for one in flight.metrics.avoidances]
    if peaks:
        times = "once" if len(peaks) == 1 else f"{len(peaks)} times"
        said.append(f"It left its path {times}, up to {max(peaks):.2f} m from the planned line.")
    elif not isinstance(figures["avoidances"], Unknown):
        said.append("It never left its path.")
    near = figures["clearance_min_m"]
    limit = flight.mission.limits.clearance
    if isinstance(near, Unknown):
        said.append(f"How near it came to obstacles is not known: {near.why}.")
    else:
        said.append(f"The nearest obstacle was {near:.2f} m from its centre (limit {limit:.2f} m).")
    covered, strip = figures["coverage_percent"], figures["missed_strip_m"]
    if not isinstance(covered, Unknown) and not isinstance(strip, Unknown):
        said.append(
            f"It sprayed {covered:.1f} % of the planned strips; "
            f"the longest stretch missed is {strip:.1f} m."
        )
    return said


def _route(distance: Figure, duration: Figure) -> str:
    if isinstance(distance, Unknown) or isinstance(duration, Unknown):
        why = distance if isinstance(distance, Unknown) else duration
        reason = why.why if isinstance(why, Unknown) else ""
        return f"The route was not completed: {reason}."
    return f"It flew the whole route, {distance:.1f} m, in {clock(duration)}."


def story(turn: Turn, begin: float) -> list[str]:
    """Why it turned and what came of it; times count from `begin`, s on the flight clock."""
    said = [_choice(choice, begin, again=bool(i)) for i, choice in enumerate(turn.choices[:4])]
    if len(turn.choices) > 4:
        said.append(f"More decisions in this avoidance: {len(turn.choices) - 4}.")
    if not turn.choices:
        said.append(
            "The log holds no decision of the planner that explains it: "
            "wind, the pilot or the estimate may have moved it."
        )
    said += [_map(turn)] if turn.map_delay is not None else []
    peak = f"It went up to {turn.avoidance.peak_m:.2f} m from the planned line"
    if isinstance(turn.clearance, Unknown):
        said.append(f"{peak}. Its clearance is not known: {turn.clearance.why}.")
    else:
        what = turn.passed or "the nearest obstacle"
        said.append(f"{peak} and passed {what} at {turn.clearance:.2f} m.")
    seconds = turn.avoidance.end - turn.avoidance.start
    drop = turn.avoidance.altitude_drop_m
    height = "kept its height" if drop < 0.1 else "lost height"
    said.append(
        f"It was back on its path after {seconds:.1f} s and {height} (at most {drop:.2f} m lower)."
    )
    return said


def _map(turn: Turn) -> str:
    delay = turn.map_delay or 0.0
    when = f"{abs(delay):.1f} s {'after' if delay >= 0 else 'before'}"
    seen = f"{len(turn.cells_site)} columns of cells stood at flight height"
    return f"The map drawn here is the one logged {when} it decided; {seen}."


def _choice(choice: Choice, begin: float, again: bool) -> str:
    where = f" {choice.blocked_at:.1f} m ahead" if choice.blocked_at else ""
    verb = {
        "avoid": f"the map showed something in the way{where}, and it took a new path",
        "stop": f"the way was blocked{where} and no way round was found, so it braked",
    }.get(choice.decision, f"it decided \u201c{choice.decision}\u201d")
    if again and choice.decision == "avoid":
        verb = f"it saw it{where} and chose anew" if where else "it went on with a new curve"
    took = "" if choice.took_ms is None else f", and deciding took {choice.took_ms:.1f} ms"
    own = f"Its reason, as logged: \u201c{choice.why}\u201d."
    age = f"The depth image was {1e3 * choice.frame_age:.0f} ms old{took}."
    return f"At {choice.time - begin:.1f} s {verb}. {own} {age}"
