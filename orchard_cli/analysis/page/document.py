"""One self-contained page: nothing is fetched, whoever opens it and wherever."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from html import escape
from importlib import resources
from string import Template

from ..flight import Flight, names
from ..paper import Published
from . import charts, sections


def page(flights: Sequence[Flight], published: Sequence[Published] = ()) -> str:
    """The page of one flight, or of several side by side; at least one."""
    from plotly.offline import get_plotlyjs

    called = names(flights)
    drawn = {
        "above": charts.above(flights, called),
        "space": charts.space(flights, called),
        "curves": charts.curves(flights, called),
    }
    skeleton = Template(_resource("template.html"))
    return skeleton.substitute(
        title=escape(_title(flights, called)),
        facts="<br>".join(
            (f"<b>{escape(name)}</b> · " if len(flights) > 1 else "") + sections.facts(flight)
            for name, flight in zip(called, flights, strict=True)
        ),
        style=_resource("page.css"),
        script=_resource("page.js"),
        body=_body(flights, called, published),
        plotly=get_plotlyjs().replace("</script", "<\\/script"),
        charts=json.dumps(drawn, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"),
    )


def _title(flights: Sequence[Flight], called: Sequence[str]) -> str:
    if len(flights) == 1:
        return f"{flights[0].mission.name}, flown by {called[0]}"
    return f"{flights[0].mission.name}: {' against '.join(called)}"


_SHADED = (
    'Shaded: avoidances. <span class="screen">Drag to zoom in, double-click to zoom out.</span>'
)


def _body(flights: Sequence[Flight], called: Sequence[str], published: Sequence[Published]) -> str:
    several = len(flights) > 1
    first = flights[0]
    shape = _aspect(first)
    curves = "Along the route" if several else "Over time"
    shaded = "" if several else _SHADED
    parts = [
        _part("summary", "Summary", _each(flights, called, _summary)),
        _part("verdicts", "Verdicts", _each(flights, called, sections.verdicts)),
        _part("above", "From above",
              f'<div class="chart" data-chart="above" style="{shape}"></div>'),
        _part("space", "In three dimensions", '<div class="chart deep" data-chart="space"></div>'),
        _part("curves", curves, f'<p class="quiet">{shaded}</p><div class="chart tall '
              f'{"taller" if several else ""}" data-chart="curves"></div>'),
        *([_part("met", "Avoidances side by side", sections.met_together(flights, called))]
          if several else []),
        _part("turns", "Why it turned", _each(flights, called, sections.avoidances)),
        _part("coverage", "What was sprayed", _each(flights, called, sections.coverage)),
        _part("timings", "Onboard timings", _each(flights, called, sections.timings)),
        _part("figures", "Every figure", sections.figures(flights, called, published)
              + sections.unknown(flights, called) + sections.sources(published)),
    ]  # fmt: skip
    return "".join(parts)


def _summary(flight: Flight) -> str:
    return sections.tiles(flight) + sections.summary(flight)


def _part(name: str, title: str, inner: str) -> str:
    return f'<section id="{name}"><h2>{escape(title)}</h2>{inner}</section>'


def _each(flights: Sequence[Flight], called: Sequence[str], make: Callable[[Flight], str]) -> str:
    if len(flights) == 1:
        return make(flights[0])
    return "".join(
        f'<h3 class="who">{escape(name)}</h3>{make(flight)}'
        for name, flight in zip(called, flights, strict=True)
    )


def _aspect(flight: Flight) -> str:
    """The chart's shape follows the orchard's, within reason."""
    span = flight.mission.waypoints_site[:, :2]
    wide, high = (span.max(axis=0) - span.min(axis=0)) + 8.0
    return f"aspect-ratio:{min(max(wide / high, 0.6), 3.0):.3f}"


def _resource(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
