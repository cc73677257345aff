"""The grand table as Markdown and as one picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from .worlds import METRICS, SYSTEMS, Flown, measured_flights, senses

_SHORT = {
    "contacts": "contacts",
    "clearance_min_m": "least distance, m",
    "deviation_max_m": "off the route, most, m",
    "deviation_mean_m": "mean, m",
    "avoidances": "avoidances",
    "replan_failures": "stops",
    "duration_s": "time, s",
    "speed_max_m_s": "fastest, m/s",
    "acceleration_max_m_s2": "hardest, m/s²",
    "coverage_percent": "covered, %",
}


def markdown(flown: Sequence[Flown]) -> str:
    """A table for each world, a row for each system."""
    lines = []
    for world in dict.fromkeys(one.world for one in flown):
        heads = ("system", "senses by", *(_SHORT[name] for name in METRICS))
        lines += [f"**{world}**", "", _line(heads), _line(["---"] * len(heads))]
        for one in flown:
            if one.world == world:
                figures = [_told(one.outcome.figure(name)) for name in METRICS]
                lines.append(_line((one.system, senses(one.system), *figures)))
        lines.append("")
    return "\n".join(lines)


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _told(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def picture(file: Path, flown: Sequence[Flown]) -> None:
    """Each world from above with every system's flight, and how near each came to anything."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Circle

    from orchard_cli.analysis.overview import COLOURS

    inks = dict(zip(SYSTEMS, ("#8A8A8A", *COLOURS), strict=True))
    found = list(measured_flights(flown))
    worlds = list(dict.fromkeys(one.world for one in flown))
    sheet = Figure(figsize=(12.0, 5.0 * len(worlds)), layout="constrained")
    grid = sheet.subplots(len(worlds), 2, squeeze=False, width_ratios=(2.0, 1.0))
    for (above, beside), world in zip(grid, worlds, strict=True):
        here = [(one, flight) for one, flight in found if one.world == world]
        for one, flight in here:
            track = (flight.log.truth or flight.log.odometry).positions_site
            above.plot(*track[:, :2].T, color=inks[one.system], linewidth=1.0, label=one.system)
        if here and here[0][1].world is not None:
            for pole in here[0][1].world.poles:
                above.add_patch(Circle((pole.x, pole.y), 0.3, color="black"))
        above.set(title=f"{world}, from above", xlabel="m", ylabel="m", aspect="equal")
        if here:
            above.legend(fontsize=8, loc="upper right")
        nearest = [one.outcome.figure("clearance_min_m") or 0.0 for one, _ in here]
        names = [one.system for one, _ in here]
        bars = beside.barh(names, nearest, color=[inks[name] for name in names])
        touched = [one.outcome.figure("contacts") for one, _ in here]
        beside.bar_label(bars, ["touched" if count else "" for count in touched], padding=3)
        beside.invert_yaxis()
        beside.set(title="least distance to anything", xlabel="m")
    sheet.savefig(file, dpi=80)
