"""`orchard plan`, as a shell sees it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from orchard_cli import mission as missions

SURVEY = Path(__file__).parents[2] / "missions" / "lemon-field.survey.toml"


def orchard_plan(*arguments):
    return subprocess.run(
        [sys.executable, "-c", "from orchard_cli.commands import main; main()", "plan", *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_json_is_one_document_on_stdout_with_the_promised_keys(tmp_path):
    out = tmp_path / "field.json"
    done = orchard_plan(str(SURVEY), "-o", str(out), "--json")
    assert (done.returncode, done.stderr) == (0, "")
    figures = json.loads(done.stdout)
    mission = missions.load(out)
    assert figures["mission"] == str(out)
    assert figures["route_length_m"] == round(mission.route_length, 3)
    assert figures["waypoints"] == 10
    assert figures["duration_s"] == round(mission.duration, 2)
    assert figures["control_points"] == 449
    assert 0 < figures["corner_cut_m"] <= 1.5
    assert figures["energy_share"] == round(mission.energy_share, 4)


def test_the_mission_goes_beside_its_survey_and_quiet_is_quiet(tmp_path):
    survey = tmp_path / "north.survey.toml"
    survey.write_bytes(SURVEY.read_bytes())
    done = orchard_plan(str(survey), "-q")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert missions.load(tmp_path / "north.mission.json").provenance.survey == survey.name


def test_a_wrong_survey_ends_with_2_a_line_a_fault_and_no_file(tmp_path):
    survey = tmp_path / "bad.toml"
    text = SURVEY.read_text(encoding="utf-8").replace("23.45", "123.45")
    survey.write_text(text.replace("gaps_m = [2.8", "gaps_m = [-2.8"), encoding="utf-8")
    done = orchard_plan(str(survey))
    assert done.returncode == 2
    assert done.stdout == ""
    lines = done.stderr.splitlines()
    assert len(lines) == 2
    assert lines[0].startswith("orchard: bad.toml: site: latitude_deg: is 123.45; ")
    assert lines[1].startswith("orchard: bad.toml: row 1: gaps_m[1]: is -2.8; ")
    assert list(tmp_path.iterdir()) == [survey]


def test_a_mission_never_overwrites_its_survey(tmp_path):
    survey = tmp_path / "north.toml"
    survey.write_bytes(SURVEY.read_bytes())
    assert orchard_plan(str(survey), "-o", str(survey)).returncode == 2
    assert survey.read_bytes() == SURVEY.read_bytes()


@pytest.mark.parametrize("survey", [".", "", "/"])
def test_a_folder_in_place_of_a_survey_is_told_in_one_line(survey):
    done = orchard_plan(survey)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "is no regular file" in line


def test_a_drawing_is_planned_unasked_where_stdin_is_no_terminal(tmp_path):
    folder, out = SURVEY.parent, tmp_path / "m.json"
    settings = str(folder / "lemon-field.settings.toml")
    drawn = str(folder / "lemon-field.trees.geojson")
    done = orchard_plan(drawn, "--settings", settings, "-o", str(out), "--json")
    assert (done.returncode, done.stderr) == (0, "")
    figures = json.loads(done.stdout)
    assert (figures["waypoints"], figures["notes"][0]) == (10, "a boundary")
    assert figures["route_length_m"] == pytest.approx(224.33, abs=0.01)
