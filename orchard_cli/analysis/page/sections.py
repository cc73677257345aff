"""The parts of the page as HTML: every text from a log is escaped here."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from ..aligned import met
from ..comparison import Delta, comparison, delta, latencies
from ..figures import Unknown
from ..flight import Flight
from ..paper import Published
from ..turns import Bearing, turns
from . import words
from .maps import coverage_map, turn_map

Names = Sequence[str]
FRAME_MS = 1e3 / 15  # the camera's period: a cycle must end within it

_MARKS = {True: ("kept", "✓ kept"), False: ("broken", "✗ broken"), None: ("unknown", "? not known")}


def table(head: Iterable[str], rows: Iterable[Iterable[str]], kind: str = "") -> str:
    """Cells are HTML already; the first column is a head of its row."""
    top = "".join(f'<th scope="col">{cell}</th>' for cell in head)
    body = "".join(
        "<tr>"
        + "".join(
            f'<th scope="row">{cell}</th>' if i == 0 else f"<td>{cell}</td>"
            for i, cell in enumerate(row)
        )
        + "</tr>"
        for row in rows
    )
    return (
        f'<div class="scroll"><table class="{kind}"><thead><tr>{top}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def facts(flight: Flight) -> str:
    """What flew, where and when, in one line."""
    told = flight.log.metadata
    kind = "simulated flight" if told.get("simulated") == "yes" else "real flight"
    parts = [kind, told.get("vehicle", ""), f"site {told.get('site', 'unknown')}", flight.log.file]
    return " · ".join(escape(part) for part in parts if part)


def tiles(flight: Flight) -> str:
    """The six figures that are looked for first."""
    chosen = (
        "distance_m",
        "duration_s",
        "avoidances",
        "clearance_min_m",
        "deviation_mean_m",
        "coverage_percent",
    )
    figures = flight.metrics.figures
    return '<div class="tiles">' + "".join(
        f"<div><b>{escape(words.with_unit(name, figures[name]))}</b>"
        f"<span>{escape(words.label(name))}</span></div>"
        for name in chosen
    ) + "</div>"  # fmt: skip


def summary(flight: Flight) -> str:
    """Sentences, then what a reader must know."""
    said = "".join(f"<li>{escape(sentence)}</li>" for sentence in words.summary(flight))
    notes = "".join(f"<li>{escape(note)}</li>" for note in flight.metrics.notes)
    noted = f'<p class="quiet">To know:</p><ul class="quiet">{notes}</ul>' if notes else ""
    return f"<ul>{said}</ul>{noted}"


def verdicts(flight: Flight) -> str:
    """Each rule with its limit and what was found."""
    rows = []
    for one in flight.verdicts:
        kind, mark = _MARKS[one.kept]
        found = one.found_text or words.with_unit(one.metric, one.found)
        why = (
            f"<br><small>{escape(one.found.why)}</small>" if isinstance(one.found, Unknown) else ""
        )
        rows.append(
            (
                f'<span class="mark {kind}">{mark}</span>',
                f"{escape(one.rule)}<br><small>{escape(words.label(one.metric))}</small>",
                escape(words.with_unit(one.metric, one.limit)),
                escape(found) + (f"<br><small>{why}</small>" if why else ""),
            )
        )
    return table(("verdict", "rule", "limit", "found"), rows, "verdicts")


def avoidances(flight: Flight) -> str:
    """Why it turned, one by one."""
    found = turns(flight)
    if not found:
        return "<p>There was no avoidance.</p>"
    parts = []
    for number, turn in enumerate(found, 1):
        title = f"Avoidance {number}, {turn.avoidance.start - flight.begin:.1f} s after the start"
        told = "".join(f"<li>{escape(one)}</li>" for one in words.story(turn, flight.begin))
        parts.append(
            f'<article class="turn"><h3>{escape(title)}</h3>'
            f'<div class="pair"><div><figure>{turn_map(flight, turn, title)}</figure>'
            f"{_bearings(turn.bearings)}</div><ul>{told}</ul></div></article>"
        )
    return _TURN_KEY + "".join(parts)


def _key(*entries: tuple[str, str]) -> str:
    return '<p class="key">' + "".join(
        f'<span><i class="{kind}"></i>{escape(text)}</span>' for kind, text in entries
    ) + "</p>"  # fmt: skip


_TURN_KEY = _key(
    ("flown", "flown"),
    ("new", "the new path"),
    ("old", "the path given up"),
    ("plan", "planned Π"),
    ("cell", "what the drone's map held"),
    ("thing", "obstacle of the simulated world"),
    ("leaf", "tree"),
)
_COVER_KEY = _key(
    ("applied", "applied"),
    ("missed", "missed"),
    ("doubled", "sprayed twice"),
    ("beside", "outside the planned strips"),
    ("track", "flown"),
)


def _bearings(bearings: Sequence[Bearing]) -> str:
    rows = [
        (name, words.number(one.speed_m_s), words.number(one.height_m),
         words.number(one.deviation_max_m))
        for name, one in zip(("4 s before", "in it", "4 s after"), bearings, strict=True)
    ]  # fmt: skip
    return table(("", "mean speed (m/s)", "mean height (m)", "largest deviation (m)"), rows)


def coverage(flight: Flight) -> str:
    """What the ground got, with its figures."""
    drawn = coverage_map(flight, "what was sprayed")
    figures = flight.metrics.figures
    rows = [
        (escape(words.label(name)), escape(words.with_unit(name, figures[name])))
        for name in ("coverage_percent", "overlap_percent", "missed_strip_m")
    ]
    if drawn is None:
        why = figures["coverage_percent"]
        return f"<p>{escape(why.why) if isinstance(why, Unknown) else ''}</p>"
    return f"{_COVER_KEY}<figure>{drawn}</figure>{table(('', ''), rows, 'plain')}"


def timings(flight: Flight) -> str:
    """Each stage of the onboard cycle against the camera's period."""
    found = latencies(flight.metrics)
    if not found:
        return "<p>The log holds no planner cycles.</p>"
    full = max(FRAME_MS, *(p99 for _, p99, _ in found.values()))
    rows = []
    for stage, (median, p99, most) in found.items():
        wide, dark = (100 * min(v / full, 1.0) for v in (p99, median))
        bar = (
            f'<span class="bar"><i style="width:{wide:.1f}%"></i>'
            f'<b style="width:{dark:.1f}%"></b>'
            f'<em style="left:{100 * FRAME_MS / full:.1f}%"></em></span>'
        )
        rows.append(
            (escape(stage.replace("_", " ")), f"{median:.2f}", f"{p99:.2f}", f"{most:.2f}", bar)
        )
    head = ("stage", "median (ms)", "99 % (ms)", "largest (ms)", "median dark, 99 % light")
    period = f"The line on the right of the bars is the camera's period of {FRAME_MS:.1f} ms."
    return table(head, rows, "timings") + f'<p class="quiet">{period}</p>'


def figures(flights: Sequence[Flight], names: Names, published: Sequence[Published]) -> str:
    """Every metric over all flights, deltas to the first, the paper's figures beside."""
    rows = comparison([flight.metrics for flight in flights], published)
    several = len(flights) > 1
    head = ["metric"]
    for i, name in enumerate(names):
        head += [escape(name)] + ([f"{escape(name)} − {escape(names[0])}"] if several and i else [])
    head += [escape(paper.name) for paper in published]
    body = []
    for row in rows:
        unit = words.unit(row.metric)
        cells = [
            escape(words.label(row.metric)) + (f"\u00a0<small>({unit})</small>" if unit else "")
        ]
        for i in range(len(flights)):
            cells.append(words.number(row.cells[i].figure))
            if several and i:
                cells.append(_delta(delta(row.cells[0].figure, row.cells[i].figure)))
        cells += [words.number(cell.figure) for cell in row.cells[len(flights) :]]
        body.append(cells)
    return table(head, body, "figures")


def _delta(change: Delta | None) -> str:
    """Difference, and its share of the first where that means something."""
    if change is None:
        return ""
    if change.share is None:
        return words.signed(change.absolute)
    share = f"{change.share:+.1%}".replace("-", "−").replace("%", "\u00a0%")
    return f"{words.signed(change.absolute)} ({share})"


def met_together(flights: Sequence[Flight], names: Names) -> str:
    """Avoidances by place: what each flight did at the same obstacle."""
    rows = []
    for one in met(flights):
        cells = [f"{one.place_m:.0f}\u00a0m"]
        for avoidance in one.avoidances:
            if avoidance is None:
                cells += ["did not turn", "", ""]
            else:
                seconds = avoidance.end - avoidance.start
                cells += [
                    f"{avoidance.peak_m:.2f}",
                    words.number(avoidance.clearance_min_m),
                    f"{seconds:.1f}",
                ]
        rows.append(cells)
    head = ["place along the route"]
    for name in names:
        said = escape(name)
        head += [f"{said}: deviation (m)", f"{said}: clearance (m)", f"{said}: took (s)"]
    return table(head, rows) if rows else "<p>None of them turned aside.</p>"


def unknown(flights: Sequence[Flight], names: Names) -> str:
    """Why a figure is missing."""
    reasons: dict[str, list[str]] = {}
    for flight, name in zip(flights, names, strict=True):
        for metric, figure in flight.metrics.figures.items():
            if isinstance(figure, Unknown):
                who = "" if len(flights) == 1 else f"{name}: "
                reasons.setdefault(figure.why, []).append(who + words.label(metric))
    items = "".join(
        f"<li>{escape(why)}: {escape(', '.join(about))}</li>" for why, about in reasons.items()
    )
    return f'<p class="quiet">– is not known:</p><ul class="quiet">{items}</ul>' if items else ""


def sources(published: Sequence[Published]) -> str:
    """Where the reference columns come from."""
    lines = [line for one in published for line in (f"{one.name}: {one.source}", *one.notes)]
    items = "".join(f"<li>{escape(line)}</li>" for line in dict.fromkeys(lines))
    return f'<ul class="quiet">{items}</ul>' if items else ""
