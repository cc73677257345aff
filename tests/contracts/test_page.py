"""What a reader may rely on of the page: whole, offline, escaped, every verdict with its rule."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import made_flights as made
import numpy as np
import pytest

from orchard_cli.analysis import Clearances, Flight, measure
from orchard_cli.analysis.page import page, save
from orchard_cli.analysis.paper import PUBLISHED
from orchard_cli.analysis.verdicts import verdicts
from orchard_cli.errors import InputError
from orchard_cli.flightlog import McapRecorder, read
from orchard_cli.geometry.clearance import clearance
from orchard_cli.model.world import Pole, World

PAPER = PUBLISHED["liu2024-table2"]
VOID = {"meta", "br"}


def flown(folder, peak, name):
    plan = made.planned_mission()
    path = folder / name
    recorder = McapRecorder(path, patient=True)
    for one in made.flight(plan, made.Bump(10.0, 8.0, peak), as_planned=True):
        recorder.write(one)
    recorder.close()
    log = read(path)
    world = World("one pole", poles=(Pole(10.0, 0.0, 0.15, 6.0),))
    far = clearance(world, log.truth.positions_site, log.truth.times)
    clearances = Clearances(log.truth.times, far.obstacles, far.trees)
    metrics = measure(log, plan, clearances)
    return Flight(log, plan, world, clearances, metrics, verdicts(metrics, plan))


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    return flown(tmp_path_factory.mktemp("page"), 1.5, "one.mcap")


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    return flown(tmp_path_factory.mktemp("page"), 2.0, "two.mcap")


def without_scripts(html):
    return re.sub(r"<(script|style)\b[^>]*>.*?</\1>", "", html, flags=re.S)


def charts(html):
    found = re.search(r'<script type="application/json" id="charts">(.*?)</script>', html, re.S)
    return json.loads(found[1])


class Balance(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open = []

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_every_element_is_closed(one, two):
    for html in (page([one], PAPER), page([one, two], PAPER)):
        parser = Balance()
        parser.feed(without_scripts(html))
        assert parser.open == []


def test_nothing_is_fetched(one):
    html = page([one])
    assert "default-src 'none'" in html
    shown = without_scripts(html)
    assert not re.search(r'(?:src|href)="(?!#)', shown)
    assert "url(" not in re.search(r"<style>(.*?)</style>", html, re.S)[1]
    assert html.count("plotly.js v") == 1  # inlined once


def test_every_verdict_shows_its_rule_its_limit_and_its_figure(one):
    """MissionPlanner #1041: verdicts with no rule behind them."""
    rows = re.findall(r"<tr>(.*?)</tr>", without_scripts(page([one])), re.S)
    for verdict in one.verdicts:
        (row,) = [row for row in rows if verdict.rule.replace("'", "&#x27;") in row]
        assert re.search(r"✓ kept|✗ broken|\? not known", row)
        assert len(re.findall(r"<td>(?!</td>)", row)) == 3  # rule, limit, found


def test_each_avoidance_has_its_map_and_its_story(one):
    shown = without_scripts(page([one]))
    assert shown.count('<article class="turn">') == len(one.metrics.avoidances) == 1
    assert "passed pole 1 at 1.35 m" in shown


def test_charts_are_what_plotly_draws(one, two):
    from plotly.graph_objects import Figure

    for flights in ([one], [one, two]):
        for name, chart in charts(page(flights)).items():
            assert Figure(chart).data, name  # raises on a key or value that plotly does not know


def test_two_flights_are_set_side_by_side_at_the_same_place(one, two):
    """flight_review #191, #42: logs hard to compare two by two."""
    html = page([one, two], PAPER)
    drawn = charts(html)["curves"]
    assert drawn["layout"]["xaxis"]["title"]["text"].startswith("place along the planned route")
    first, second = [trace for trace in drawn["data"] if trace["yaxis"] == "y"]
    tops = [max(zip(trace["y"], trace["x"], strict=True)) for trace in (first, second)]
    assert [round(top, 1) for top, _ in tops] == [1.5, 2.0]
    assert abs(tops[0][1] - tops[1][1]) < 0.5  # m along the route
    shown = without_scripts(html)
    assert "guided 2 − guided 1" in shown
    assert "paper, proposed" in shown


def test_what_a_log_says_is_text_and_never_markup(one):
    nasty = "</script><script>alert(1)</script><img src=x onerror=alert(2)>"
    log = replace(
        one.log, file=nasty, metadata={**one.log.metadata, "system": nasty, "site": nasty}
    )
    metrics = replace(one.metrics, notes=(nasty,))
    html = page([replace(one, log=log, metrics=metrics)])
    assert "<img" not in html
    assert "<script>alert" not in html


def test_a_flight_that_never_reached_its_route_has_a_page(one):
    nowhere = replace(one.log, odometry=one.log.odometry.between(100.0, 100.1), truth=None)
    lost = measure(nowhere, one.mission, Clearances(*[np.empty(0)] * 3))
    html = page([replace(one, log=nowhere, metrics=lost, verdicts=verdicts(lost, one.mission))])
    assert "was not completed" in html


def test_the_page_is_written_under_a_name_for_pages_only(one, tmp_path):
    log = tmp_path / "flight.mcap"
    log.write_bytes(b"a log")
    with pytest.raises(InputError, match="another kind of file"):
        save(log, [one])
    assert log.read_bytes() == b"a log"
    save(tmp_path / "page.html", [one])
    assert [p.name for p in sorted(tmp_path.iterdir())] == ["flight.mcap", "page.html"]
