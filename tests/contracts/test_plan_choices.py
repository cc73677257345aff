"""`orchard plan` with what sprayers choose: options, sorties' files, and resume from a log."""

from __future__ import annotations

import json

import made_flights as made
import numpy as np
import pytest
import shapely
from typer.testing import CliRunner

from orchard_cli import mission as missions
from orchard_cli.analysis.coverage import flown_lines
from orchard_cli.commands.app import app
from orchard_cli.errors import InputError
from orchard_cli.flight.safety import Phase
from orchard_cli.flight.spray import SprayLines, spray
from orchard_cli.flightlog import McapRecorder, read
from orchard_cli.model.records import SprayRecord
from orchard_cli.model.vehicle import VehicleState

SURVEY = """
name = "small"
[site]
latitude_deg = 23.158
longitude_deg = 113.352
height_m = 30
heading_deg = 70
[flight]
height_m = 3.5
turn = "rounded"
headland_m = 1.5
{flight}
{tables}
[[row]]
gaps_m = [3, 3, 3, 3, 3]
tree_height_m = 2.2
[[row]]
distance_m = 5
gaps_m = [3, 3, 3, 3, 3]
tree_height_m = 2.2
[[row]]
distance_m = 5
gaps_m = [3, 3, 3, 3, 3]
tree_height_m = 2.2
"""
TANK = "[tank]\ncapacity_l = 2.0\ndose_l_ha = 150\n"


@pytest.fixture
def survey(tmp_path):
    path = tmp_path / "small.survey.toml"
    path.write_text(SURVEY.format(flight="", tables=""), encoding="utf-8")
    return path


def run(*arguments):
    return CliRunner().invoke(app, ["plan", *map(str, arguments)])


def faults(*arguments):
    done = run(*arguments)
    assert isinstance(done.exception, InputError), done.exception
    return [str(fault) for fault in done.exception.faults]


def test_sorties_are_files_of_their_own(survey, tmp_path):
    survey.write_text(SURVEY.format(flight="", tables=TANK), encoding="utf-8")
    done = run(survey, "--json", "--export", tmp_path / "a.plan", "--export", tmp_path / "a.svg")
    told = json.loads(done.stdout)
    names = ["small-1of2.mission.json", "small-2of2.mission.json"]
    assert [flight["mission"] for flight in told["sorties"]] == [str(tmp_path / n) for n in names]
    loaded = [missions.load(tmp_path / name) for name in names]
    assert [m.sortie.number for m in loaded] == [1, 2]
    assert told["liquid_l"] == pytest.approx(45 * 3.0 * 0.015, abs=0.01)
    assert told["route_length_m"] == pytest.approx(sum(m.route_length for m in loaded), abs=0.01)
    assert sorted(p.name for p in tmp_path.iterdir() if p.suffix in (".plan", ".svg")) == [
        "a-1of2.plan", "a-2of2.plan", "a.svg",
    ]  # fmt: skip


def test_an_option_stands_in_for_the_survey_s_key(survey, tmp_path):
    by_option, by_key = tmp_path / "a.json", tmp_path / "b.json"
    run(survey, "-o", by_option, "-q", "--pattern", "out_and_back", "--passes", "2")
    text = SURVEY.format(flight='pattern = "out_and_back"\npasses = 2', tables="")
    survey.write_text(text, encoding="utf-8")
    run(survey, "-o", by_key, "-q")
    a, b = (json.loads(p.read_text(encoding="utf-8")) for p in (by_option, by_key))
    a["provenance"] = b["provenance"] = None
    assert a == b
    rows = [s["row"] for s in a["segments"] if s["leg"] == "row"]
    assert rows == [0, 1, 2, 2, 1, 0]


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--headland", "-1"], "headland_m"),
        (["--overlap", "0.95"], "overlap"),
        (["--overlap", "0.2", "--passes", "2"], "passes"),
        (["--passes", "0"], "passes"),
        (["--pattern", "zigzag"], "pattern"),
        (["--turn", "u"], "turn"),
        (["--turn-radius", "nan"], "turn_radius_m"),
        (["--fly-over", "hedges"], "fly_over"),
        (["--direction", "up"], "direction"),
        (["--follow", "me"], "follow"),
        (["--speed", "40"], "speed_m_s"),
        (["--resume-at", "9:1"], "--resume-at"),
        (["--missed"], "--missed"),
        (["--resume-from", "no.mcap"], "no.mcap"),
        (["--export", "a.shp"], "a.shp"),
    ],
)
def test_a_wrong_choice_is_told_in_one_line_and_nothing_is_written(survey, options, word):
    (line,) = faults(survey, *options)
    assert word in line
    assert list(survey.parent.iterdir()) == [survey]


@pytest.mark.parametrize(
    ("tank", "word"),
    [
        ("[tank]\ncapacity_l = 10\n", "dose_l_ha"),
        ("[tank]\ncapacity_l = 10\nflow_l_min = 1\ndose_l_ha = 100\n", "dose_l_ha"),
        ("[tank]\ncapacity_l = 0\nflow_l_min = 1\n", "capacity_l"),
        ("[tank]\ncapacity_l = 10\nflow_l_min = -1\n", "flow_l_min"),
        ("[tank]\ncapacity_l = 10\nflow_l_min = 1\nflow_l_h = 1\n", "flow_l_h"),
    ],
)
def test_a_wrong_tank_is_told(survey, tank, word):
    survey.write_text(SURVEY.format(flight="", tables=tank), encoding="utf-8")
    assert any(word in line for line in faults(survey))


def flown_until(mission, stop, path):
    """A log of the mission flown as planned, the pump by the flight's own rule, cut at `stop`."""
    recorder = McapRecorder(path, patient=True)
    files = {"mission.json": missions.dumps(mission).encode()}
    on, lines = False, SprayLines.of(mission)
    for record in made.flight(mission, attachments=files, as_planned=True, start=0.0):
        if isinstance(record, SprayRecord):
            continue
        if getattr(record, "time", 0.0) > stop:
            break
        recorder.write(record)
        if isinstance(record, VehicleState):
            told = spray(lines, Phase.ROUTE, record)
            if told.on is not on:
                on = told.on
                recorder.write(SprayRecord(record.time, on, told.row, told.why))
    recorder.close()
    return path


def strips(lines, swath=3.0):
    return shapely.union_all(
        [
            shapely.LineString(np.asarray(x)[:, :2]).buffer(swath / 2, cap_style="flat")
            for x in lines
        ]
    )


def lines_of(mission):
    return [points for _, points in mission.spray_lines]


@pytest.mark.parametrize("share", [0.15, 0.42, 0.55, 0.8])
def test_resume_from_the_log_misses_and_doubles_no_strip(survey, tmp_path, share):
    """Resume after a battery change at the exact stop, the most repeated wish (QGroundControl
    #5368, #5737, #9302; ArduPilot #11351)."""
    run(survey, "-q")
    whole = missions.load(tmp_path / "small.mission.json")
    log = flown_until(whole, share * whole.trajectory.end, tmp_path / "one.mcap")
    done = run(survey, "-o", tmp_path / "rest.json", "--json", "--resume-from", log)
    assert done.exit_code == 0, done.exception
    rest = missions.load(tmp_path / "rest.json")
    first = strips(flown_lines(read(log)))
    second, wanted = strips(lines_of(rest)), strips(lines_of(whole))
    length = wanted.area / 3.0
    missed = wanted.difference(first.union(second)).area / 3.0
    doubled = first.intersection(second).area / 3.0
    assert missed < 0.003 * length
    assert doubled < 0.003 * length
    assert rest.takeoff_site == pytest.approx(whole.takeoff_site)
    assert rest.landing_site == pytest.approx(whole.takeoff_site)


def test_two_logs_one_after_the_other_leave_the_rest(survey, tmp_path):
    run(survey, "-q")
    whole = missions.load(tmp_path / "small.mission.json")
    one = flown_until(whole, 0.3 * whole.trajectory.end, tmp_path / "one.mcap")
    run(survey, "-o", tmp_path / "b.json", "-q", "--resume-from", one)
    second = missions.load(tmp_path / "b.json")
    two = flown_until(second, 0.5 * second.trajectory.end, tmp_path / "two.mcap")
    logs = ["--resume-from", one, "--resume-from", two]
    assert run(survey, "-o", tmp_path / "c.json", "-q", *logs).exit_code == 0
    third = missions.load(tmp_path / "c.json")
    done = [*flown_lines(read(one)), *flown_lines(read(two)), *lines_of(third)]
    wanted = strips(lines_of(whole))
    assert wanted.difference(strips(done)).area / 3.0 < 0.3
    assert sum(shapely.LineString(x[:, :2]).length for x in done) == pytest.approx(45.0, abs=0.3)


def test_a_log_of_another_survey_or_of_other_lines_is_refused(survey, tmp_path):
    run(survey, "-q")
    whole = missions.load(tmp_path / "small.mission.json")
    log = flown_until(whole, 20.0, tmp_path / "one.mcap")
    (line,) = faults(survey, "-o", tmp_path / "c.json", "--resume-from", log, "--passes", "2")
    assert "other lines" in line
    survey.write_text(SURVEY.format(flight="swath_m = 2.9", tables=""), encoding="utf-8")
    (line,) = faults(survey, "-o", tmp_path / "c.json", "--resume-from", log)
    assert "another survey" in line
    assert not (tmp_path / "c.json").exists()


def test_a_finished_flight_leaves_nothing(survey, tmp_path):
    run(survey, "-q")
    whole = missions.load(tmp_path / "small.mission.json")
    log = flown_until(whole, whole.trajectory.end, tmp_path / "one.mcap")
    (line,) = faults(survey, "-o", tmp_path / "c.json", "--resume-from", log)
    assert "nothing is left" in line
