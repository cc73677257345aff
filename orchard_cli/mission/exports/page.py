"""The plan as one HTML page that needs nothing else: no network, no fonts, no libraries."""

from __future__ import annotations

import html
from importlib import resources

import numpy as np
from lxml import etree

from orchard_cli.mission.notes import notes
from orchard_cli.model.mission import Leg, Mission

from .profile import side_view
from .sketch import FENCE, HEADLAND, OBSTACLE, TRANSIT, TREE, colour_of, plan_view
from .svg import MARK, drawing

_SAMPLES = 200  # of a segment, for its length


def write(missions: list[Mission]) -> bytes:
    """A page about one mission, or about the sorties of one orchard."""
    name = html.escape(missions[0].name)
    parts = [
        "<!DOCTYPE html>",
        f'<html lang="en"><head><meta charset="utf-8"><title>{name}</title>',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f'<meta name="generator" content="{MARK}">',
        f"<style>{_resource('page.css')}</style></head><body><main>",
        f'<h1>{name}</h1><p class="sub">{_where(missions[0])}</p>',
        _cards(missions),
        _warnings(missions),
        _map(missions),
        *(_side(mission, k, len(missions)) for k, mission in enumerate(missions)),
        *(_table(mission, len(missions)) for mission in missions),
        f"<footer>{_made(missions[0])}</footer></main>",
        f"<script>{_resource('page.js')}</script></body></html>\n",
    ]
    return "\n".join(part for part in parts if part).encode()


def _resource(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text("utf-8")


def _where(mission: Mission) -> str:
    origin = mission.orchard.origin
    heading = np.degrees(origin.heading) % 360
    return (
        f"First tree at {origin.latitude_deg:.6f}°, {origin.longitude_deg:.6f}°, "
        f"{origin.height:g} m ({origin.height_reference.value}); rows run towards {heading:.0f}°"
    )


def _cards(missions: list[Mission]) -> str:
    route = sum(mission.route_length for mission in missions)
    flight = sum(mission.trajectory.end for mission in missions)
    battery = max(mission.energy_share for mission in missions)
    sprayed = sum(_sprayed(mission) for mission in missions)
    cards = [
        (f"{route:.0f} m", "route"),
        (f"{sprayed:.0f} m", "with the pump on"),
        (f"{flight // 60:.0f} min {flight % 60:.0f} s", "in the air"),
        (f"{battery:.0%}", "of a battery" + (", at most" if len(missions) > 1 else "")),
        (str(len(missions[0].orchard.rows)), "rows"),
        (f"{missions[0].limits.speed:g} m/s", "at most"),
    ]
    if len(missions) > 1:
        cards.insert(0, (str(len(missions)), "sorties"))
    liquid = [mission.liquid for mission in missions if mission.liquid is not None]
    if liquid:
        cards.append((f"{sum(liquid):.1f} l", "of liquid"))
    inner = "".join(
        f'<div class="card"><b>{value}</b><span>{word}</span></div>' for value, word in cards
    )
    return f'<div class="cards">{inner}</div>'


def _sprayed(mission: Mission) -> float:
    return sum(
        float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        for _, points in mission.spray_lines
    )


def _warnings(missions: list[Mission]) -> str:
    found = sorted({note for mission in missions for note in notes(mission)})
    if not found:
        return ""
    listed = "".join(f"<p>{html.escape(note)}</p>" for note in found)
    return f'<section class="warn"><h2>In the way</h2>{listed}</section>'


def _map(missions: list[Mission]) -> str:
    picture = _svg(drawing(plan_view(missions), "The plan from above"))
    buttons = "".join(
        f'<button value="{value}" aria-label="{word}">{sign}</button>'
        for value, word, sign in (("0.7", "closer", "+"), ("1.43", "wider", "−"),
                                  ("all", "all", "⤢"))
    )  # fmt: skip
    entries = [
        (colour_of(k), "", "spray" if len(missions) == 1 else f"spray, sortie {k + 1}")
        for k in range(len(missions))
    ]
    entries += [(HEADLAND.stroke, "", "headland, pump off"),
                (TRANSIT.stroke, "dotted", "transit, pump off"),
                (TREE.fill, "dot", "tree")]  # fmt: skip
    orchard = missions[0].orchard
    if orchard.obstacles:
        entries.append((OBSTACLE.fill, "dot", "known obstacle, its clearance"))
    if len(orchard.fence_site) or orchard.keep_outs_site:
        entries.append((FENCE.stroke, "dashed", "fence, keep-out"))
    legend = "".join(_entry(*entry) for entry in entries)
    return (
        f'<section><div class="map">{picture}<div class="zoom">{buttons}</div></div>'
        f'<ul class="legend">{legend}</ul></section>'
    )


def _entry(colour: str, kind: str, word: str) -> str:
    if kind == "dot":
        return f'<li><i class="dot" style="background:{colour}"></i>{word}</li>'
    return f'<li><i style="border-color:{colour};border-style:{kind or "solid"}"></i>{word}</li>'


def _svg(root: etree._Element) -> str:
    return str(etree.tostring(root, encoding="unicode"))


def _side(mission: Mission, k: int, of: int) -> str:
    title = "Height over the distance flown" + (f", sortie {k + 1}" if of > 1 else "")
    picture = _svg(drawing(side_view(mission, colour_of(k)), title))
    return f'<section><h2>{title}</h2><div class="chart">{picture}</div></section>'


def _table(mission: Mission, of: int) -> str:
    lines = []
    for segment in mission.segments:
        name = segment.leg.value + (f" {segment.row + 1}" if segment.row is not None else "")
        pump = '<td class="on">on</td>' if segment.leg is Leg.ROW else "<td>off</td>"
        times = np.linspace(segment.start, segment.end, _SAMPLES)
        path = mission.trajectory.sample(times)[0]
        length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        lines.append(
            f"<tr><td>{name}</td>{pump}<td>{segment.start:.0f} s</td>"
            f"<td>{segment.end:.0f} s</td><td>{length:.1f} m</td></tr>"
        )
    sortie = mission.sortie
    title = f"Sortie {sortie.number}" if sortie is not None and of > 1 else "Leg by leg"
    return (
        f'<section><h2>{title}</h2><div class="scroll"><table><tr><th>leg</th><th>pump</th>'
        f"<th>from</th><th>to</th><th>length</th></tr>{''.join(lines)}</table></div></section>"
    )


def _made(mission: Mission) -> str:
    made = mission.provenance
    return html.escape(
        f"Planned from {made.survey} by orchard {made.tool_version} at {made.created_utc}. "
        "x runs along the rows; the picture is turned so that x points right."
    )
