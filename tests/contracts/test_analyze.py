"""What people and scripts may rely on of `orchard analyze`."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import made_flights as made
import numpy as np
import pytest
from typer.testing import CliRunner

from orchard_cli.commands.app import app
from orchard_cli.errors import InputError
from orchard_cli.flightlog import McapRecorder
from orchard_cli.mission import dumps
from orchard_cli.model.records import OccupiedCells, TruthRecord

WORLD = b"""
name = "one pole"
trees = "survey"
[[pole]]
x_m = 10.0
y_m = 0.0
radius_m = 0.15
height_m = 6.0
"""
NAMES = [
    "distance_m",
    "duration_s",
    "deviation_mean_m",
    "deviation_rms_m",
    "deviation_p95_m",
    "deviation_max_m",
    "avoidance_peak_mean_m",
    "speed_max_m_s",
    "acceleration_max_m_s2",
    "yaw_rate_max_rad_s",
    "yaw_rate_mean_rad_s",
    "clearance_min_m",
    "coverage_percent",
]  # DESIGN.md


def write_log(path: Path, peak: float = 1.5, attachments=None, change=lambda records: records):
    plan = made.planned_mission()
    files = {"mission.json": dumps(plan).encode(), "world.toml": WORLD}
    files = files if attachments is None else attachments
    detour = made.Bump(10.0, 8.0, peak)
    recorder = McapRecorder(path, patient=True)
    for one in change(made.flight(plan, detour, attachments=files, as_planned=True)):
        recorder.write(one)
    recorder.close()
    assert recorder.losses == {}
    return path


def as_if_real(records):
    """Without truth; with a pole, a canopy and the ground in the map."""
    header, *rest = records
    yield replace(header, simulated=False, seed=None)
    cells = [[10.0, 0.0, 3.5], [0.0, 0.0, 2.6], [5.0, 0.0, 0.0]]  # a pole, a canopy, the ground
    yield OccupiedCells(100.0, np.array(cells), 0.1)
    yield from (one for one in rest if not isinstance(one, TruthRecord))


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return write_log(tmp_path_factory.mktemp("logs") / "one.mcap")


@pytest.fixture(scope="module")
def other(tmp_path_factory):
    return write_log(tmp_path_factory.mktemp("logs") / "two.mcap", peak=2.0)


def analyze(*words):
    return CliRunner().invoke(app, ["analyze", *map(str, words)])


def test_json_is_one_document_with_every_metric_of_the_design(log):
    result = analyze(log, "--json")
    assert result.exit_code == 0
    document = json.loads(result.stdout)
    assert document["schema"] == "orchard-analyze/1"
    (entry,) = document["logs"]
    assert entry["file"] == "one.mcap"
    assert entry["system"] == "guided"
    assert not set(NAMES) - set(entry["metrics"])
    assert {n for n, v in entry["metrics"].items() if v is None} == set(entry["unknown"])
    assert entry["metrics"]["clearance_min_m"] == pytest.approx(1.35, abs=0.05)
    assert [round(one["peak_m"], 1) for one in entry["avoidances"]] == [1.5]
    assert all(verdict["rule"] for verdict in entry["verdicts"])
    assert entry["notes"]


def test_several_logs_stand_side_by_side_beside_the_paper(log, other):
    result = analyze(log, other, "--paper", "liu2024-table1")
    assert result.exit_code == 0
    for word in ("distance_m", "paper,", "311.360", "467.670", "352.80", "one.mcap", "two.mcap"):
        assert word in result.stdout, word


def test_flights_of_one_system_are_numbered_and_no_figure_is_cut_or_wrapped(log, other):
    said = analyze(log, other, log, "--paper", "liu2024-table1").stdout  # 80 characters wide
    assert max(map(len, said.splitlines())) <= 80
    for word in ("guided 1", "guided 2", "guided 3", "guided 2: two.mcap", "paper, ego"):
        assert word in said, word
    assert "…" not in said
    assert len(re.findall(r"\([+-][\d.]+%\)", said)) == said.count("(+") + said.count("(-") > 10


def test_one_bad_log_does_not_hide_the_good_ones(log, tmp_path):
    bad = tmp_path / "bad.mcap"
    bad.write_bytes(b"not a log at all")
    result = analyze(bad, log, "--json")
    assert isinstance(result.exception, InputError)
    assert result.exception.exit_code == 2
    assert "is no MCAP log" in str(result.exception)
    good, failed = json.loads(result.stdout)["logs"]
    assert good["file"] == "one.mcap"
    assert failed["file"] == "bad.mcap"
    assert "error" in failed
    assert "metrics" not in failed


def test_a_cut_log_is_measured_as_far_as_it_goes_and_says_so(log, tmp_path):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(log.read_bytes()[: log.stat().st_size * 2 // 3])
    result = analyze(cut, "--json")
    assert result.exit_code == 0
    (entry,) = json.loads(result.stdout)["logs"]
    assert entry["metrics"]["distance_m"] is None
    assert entry["unknown"]["distance_m"] == "the last waypoint was not reached"
    assert entry["metrics"]["deviation_max_m"] == pytest.approx(1.5, abs=0.1)
    assert any("cut off" in note for note in entry["notes"])


def test_a_real_flights_clearance_is_from_its_maps_obstacles_at_flight_height(tmp_path):
    result = analyze(write_log(tmp_path / "real.mcap", change=as_if_real), "--json")
    (entry,) = json.loads(result.stdout)["logs"]
    assert entry["metrics"]["clearance_min_m"] == pytest.approx(1.45, abs=0.05)
    assert "the world is not known" in entry["unknown"]["clearance_trees_min_m"]


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_picture_is_drawn(log, tmp_path, suffix):
    path = tmp_path / f"overview.{suffix}"
    assert analyze(log, "--json", "--picture", path).exit_code == 0
    head = path.read_bytes()[:200]
    assert head.startswith(b"\x89PNG") if suffix == "png" else b"<?xml" in head


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--picture", "overview.txt"], "no kind of picture"),
        (["--picture", "no/such/folder/overview.png"], "cannot be written"),
        (["--paper", "liu2025"], "no figures named"),
    ],
)
def test_wrong_options_are_told_in_one_line(log, words, complaint):
    result = analyze(log, *words)
    assert isinstance(result.exception, InputError)
    assert complaint in str(result.exception)
    assert "\n" not in str(result.exception)


def test_a_log_without_its_mission_is_refused(tmp_path):
    result = analyze(write_log(tmp_path / "bare.mcap", attachments={}), "--json")
    assert "holds no mission" in str(result.exception)


def test_compare_tells_the_differences_to_the_first_place_by_place(log, other):
    """flight_review #191, #42: logs hard to compare two by two."""
    result = analyze(log, other, "--compare", "--json")
    assert result.exit_code == 0
    found = json.loads(result.stdout)["comparison"]
    assert found["reference"] == "one.mcap"
    (one,) = found["deltas"]
    assert one["file"] == "two.mcap"
    peak = one["metrics"]["avoidance_peak_mean_m"]
    assert peak["absolute"] == pytest.approx(0.5, abs=0.02)
    assert peak["share"] == pytest.approx(1 / 3, abs=0.02)
    assert one["metrics"]["liquid_used_l"] is None
    (met,) = found["avoidances"]
    assert met["peak_m"] == pytest.approx([1.5, 2.0], abs=0.02)


def test_compare_prints_a_column_of_differences_and_the_paper(log, other):
    said = analyze(log, other, "--compare", "--paper", "liu2024-table1").stdout
    for word in ("guided 2 - guided 1", "+0.500 (+33.3%)", "paper, ego", "Avoidances along"):
        assert word in said, word
    assert max(map(len, said.splitlines())) <= 80


def test_compare_needs_two(log):
    assert "needs two logs" in str(analyze(log, "--compare").exception)
