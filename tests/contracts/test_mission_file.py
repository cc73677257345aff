"""Mission files: the shipped schema holds, nothing is lost on the way, nothing wrong gets in."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli import mission as missions
from orchard_cli import survey
from orchard_cli.errors import InputError
from orchard_cli.model.mission import Provenance

MISSIONS = Path(__file__).parents[2] / "missions"
TEXT = (MISSIONS / "lemon-field.mission.json").read_text(encoding="utf-8")

SURVEY = """
[site]
latitude_deg = 23.45
longitude_deg = 113.2
height_m = 20.0
heading_deg = 211.7
[flight]
height_m = 3.5
[[obstacle]]
x_m = 3.0
y_m = 3.0
radius_m = 0.2
height_m = 3.0
[fence]
points_m = [[-20, -20], [50, -20], [50, 50], [-20, 50]]
[[keep_out]]
points_m = [[30, 30], [33, 30], [33, 33]]
[[row]]
gaps_m = [3.0, 2.5]
tree_height_m = 2.0
[[row]]
distance_m = 6.0
gaps_m = [3.0, 2.5]
tree_height_m = 2.0
ground_m = [0.1, 0.2, 0.3]
"""


@pytest.fixture(scope="module")
def mission():
    read = survey.parse(SURVEY.encode(), "north.survey.toml")
    provenance = Provenance(read.file, read.sha256, "0.1", "2026-01-01T00:00:00+00:00")
    return missions.plan(read.orchard, read.wishes, provenance)


def changed(change):
    document = json.loads(TEXT)
    change(document)
    return json.dumps(document)


def faults_of(text):
    with pytest.raises(InputError) as caught:
        missions.loads(text, "m.json")
    return caught.value.faults


def test_the_schema_is_a_schema():
    jsonschema.Draft202012Validator.check_schema(missions.schema())


def test_written_missions_obey_the_schema(mission):
    jsonschema.validate(json.loads(missions.dumps(mission)), missions.schema())


def test_a_mission_comes_back_from_its_file_to_the_last_bit(mission, tmp_path):
    path = tmp_path / "north.mission.json"
    missions.save(mission, path)
    back = missions.load(path)
    assert missions.dumps(back) == missions.dumps(mission)
    assert back.orchard.origin == mission.orchard.origin
    assert back.limits == mission.limits
    assert back.segments == mission.segments
    assert back.provenance == mission.provenance
    assert np.array_equal(
        back.trajectory.control_points_site, mission.trajectory.control_points_site
    )
    assert np.array_equal(back.orchard.fence_site, mission.orchard.fence_site)
    assert np.array_equal(back.orchard.keep_outs_site[0], mission.orchard.keep_outs_site[0])
    assert np.array_equal(back.orchard.rows[1].ground, [0.1, 0.2, 0.3])
    assert back.orchard.obstacles[0].top == 3.0


def test_a_failed_write_leaves_the_old_file(mission, tmp_path, monkeypatch):
    path = tmp_path / "m.json"
    path.write_text(TEXT, encoding="utf-8")

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(InputError, match="No space left"):
        missions.save(mission, path)
    assert path.read_text(encoding="utf-8") == TEXT
    assert os.listdir(tmp_path) == ["m.json"]


@pytest.mark.parametrize("content", [SURVEY, "", "[]", '{"schema": "other"}', TEXT[:-9]])
def test_what_is_no_mission_is_never_overwritten(mission, tmp_path, content):
    path = tmp_path / "precious"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match="is no mission; move it away, or choose another with -o"):
        missions.save(mission, path)
    assert path.read_text(encoding="utf-8") == content


def test_a_mission_is_written_through_a_link_over_the_older_one(mission, tmp_path):
    (tmp_path / "old.json").write_text(TEXT, encoding="utf-8")
    (tmp_path / "link.json").symlink_to("old.json")
    missions.save(mission, tmp_path / "link.json")
    assert (tmp_path / "link.json").is_symlink()
    assert (tmp_path / "old.json").read_text(encoding="utf-8") == missions.dumps(mission)


def test_pipes_folders_and_circular_links_are_neither_written_nor_read(mission, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "circle").symlink_to("circle")
    for name in ("pipe", "", "circle"):
        with pytest.raises(InputError):
            missions.save(mission, tmp_path / name)
        with pytest.raises(InputError):
            missions.load(tmp_path / name)
    assert (tmp_path / "pipe").is_fifo()
    assert (tmp_path / "circle").is_symlink()


def test_a_write_to_nowhere_says_where(mission, tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        missions.save(mission, tmp_path / "no" / "m.json")


def test_a_missing_file_says_so(tmp_path):
    with pytest.raises(InputError, match="is no file"):
        missions.load(tmp_path / "none.json")


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "not JSON"),
        ("[]", "no mission file"),
        ("{}", "no mission file"),
        ("[" * 100_000, "not JSON"),
        (b"\xff\xfe\x00", "UTF-8"),
        (b"\x80abc", "UTF-8"),
        ('{"schema": "orchard-mission", "version": 3}', "this program reads 1 to 2"),
        ('{"schema": "orchard-mission", "schema": "orchard-mission"}', "twice"),
        (TEXT.replace("0.2,", "NaN,", 1), "NaN"),
        (TEXT.replace("0.2,", "1e999,", 1), ""),
    ],
)
def test_what_is_no_mission_is_refused(text, what):
    assert what in str(faults_of(text)[0])


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda d: d.pop("limits"), "file"),
        (lambda d: d.update(colour="red"), "file"),
        (lambda d: d["limits"].update(speed_m_s="fast"), "limits/speed_m_s"),
        (lambda d: d["limits"].update(speed_m_s=-1), "limits/speed_m_s"),
        (lambda d: d["limits"].update(reserve=0), "limits/reserve"),
        (lambda d: d["orchard"]["origin"].update(latitude_deg=95), "orchard/origin/latitude_deg"),
        (lambda d: d["waypoints_m"][2].pop(), "waypoints_m/2"),
        (lambda d: d["trajectory"].update(interval_s=1e-9), "trajectory/interval_s"),
        (lambda d: d["segments"][1].update(leg="spin"), "segments/1/leg"),
        (lambda d: d["spline"].update(degree=2), "spline/degree"),
        (lambda d: d.update(corner_cut_m=3.1), "corner_cut_m"),
        (lambda d: d.update(name="a\x1b[2Jb"), "name"),
        (lambda d: d.update(name="a\n"), "name"),
    ],
)
def test_a_fault_of_the_schema_is_told_with_its_place(change, where):
    assert [f.where for f in faults_of(changed(change))] == [f"m.json: {where}"]


def test_faults_of_the_schema_are_told_together():
    def change(d):
        d["limits"]["speed_m_s"] = None
        d["energy_share"] = 2
        d["segments"][0]["start_s"] = "now"

    assert len(faults_of(changed(change))) == 3


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda d: d["spline"]["knots_m"].pop(), ""),
        (lambda d: d["orchard"]["rows"][0]["tree_heights_m"].pop(), ""),
        (lambda d: d["orchard"]["rows"][0]["tree_heights_m"].__setitem__(0, 4.0), "row 1, tree 1"),
        (lambda d: d["limits"].update(speed_m_s=0.5), "trajectory"),
        (lambda d: d["limits"].update(endurance_s=200), "trajectory"),
        (lambda d: d["limits"].update(endurance_s=400), "energy_share"),
        (lambda d: d.update(energy_share=0.85), "battery"),
        (lambda d: d["waypoints_m"][3].__setitem__(1, 9.0), "waypoints"),
        (lambda d: d["trajectory"]["control_points_m"][300].__setitem__(2, 2.0), "row"),
        (lambda d: d["segments"].pop(2), "segments"),
        (lambda d: d["spline"]["knots_m"].__setitem__(9, 0.1), ""),
        (lambda d: d["spline"]["knots_m"].__setitem__(9, d["spline"]["knots_m"][10]), "spline kn"),
        (lambda d: d["spline"]["knots_m"].__setitem__(3, 0.1), "spline knots"),
        (lambda d: d["spline"]["knots_m"].__setitem__(slice(-4, None), [9e4] * 4), "spline knots"),
        (lambda d: d["spline"]["control_points_m"][40].__setitem__(2, 9.0), "spline"),
        (lambda d: d["spline"]["control_points_m"].reverse(), "spline"),
        (
            lambda d: d["orchard"].update(fence_m=[[-50, -50], [90, 90], [90, -50], [-50, 90]]),
            "fence",
        ),
        (lambda d: d["orchard"].update(fence_m=[[-50, -50], [90, 90]]), "fence"),
        (lambda d: d["orchard"].update(keep_outs_m=[[[0, 0], [9, 9], [9, 0], [0, 9]]]), "keep_out"),
    ],
)
def test_a_fault_of_the_physics_is_refused(change, where):
    assert any(where in f.where for f in faults_of(changed(change)))


def test_a_spline_that_misses_the_waypoints_is_told():
    def change(d):
        points = d["spline"]["control_points_m"]
        points[:] = [points[0]] * (len(points) - 1) + [points[-1]]

    assert "passes too far from a waypoint" in [f.what for f in faults_of(changed(change))]


def test_no_more_than_twenty_faults_of_the_schema_are_told():
    faults = faults_of(changed(lambda d: d.update(waypoints_m=[None] * 5000)))
    assert len(faults) == 21
    assert faults[-1].what == "has more faults than these"


@given(st.data())
@settings(max_examples=40, deadline=None, derandomize=True)
def test_no_mutilated_mission_makes_loading_fail_in_another_way(data):
    at = data.draw(st.integers(0, len(TEXT) - 1))
    put = data.draw(st.sampled_from(["", "-", "9", "null", "[]", "e9", '"', "}", "\x00"]))
    cut = data.draw(st.integers(0, 40))
    with suppress(InputError):
        missions.loads(TEXT[:at] + put + TEXT[at + cut :])


def test_a_file_of_version_1_is_read_as_the_mission_that_it_was():
    """Version 1 did not say which waypoint a segment reaches."""
    old = json.loads(TEXT)
    old["version"] = 1
    for segment in old["segments"]:
        del segment["until"]
    assert missions.dumps(missions.loads(json.dumps(old))) == TEXT


@pytest.mark.parametrize("change", [1, -1, 100])
def test_segments_reach_the_waypoints_one_after_another(change):
    told = json.loads(TEXT)
    told["segments"][2]["until"] += change
    assert any("segments/until" in f.where for f in faults_of(json.dumps(told)))


def test_a_tank_and_a_sortie_are_kept():
    told = json.loads(TEXT)
    seconds = sum(s["end_s"] - s["start_s"] for s in told["segments"] if s["leg"] == "row")
    liquid = round(seconds * 1.7 / 60, 6)
    told |= {"tank": {"capacity_l": 10, "flow_l_min": 1.7}, "liquid_l": liquid}
    told["sortie"] = {"number": 2, "of": 3}
    mission = missions.loads(json.dumps(told))
    assert mission.tank.flow == pytest.approx(1.7 / 60)
    again = json.loads(missions.dumps(mission))
    assert {key: again[key] for key in ("tank", "liquid_l", "sortie")} == {
        "tank": {"capacity_l": 10, "flow_l_min": 1.7},
        "liquid_l": liquid,
        "sortie": {"number": 2, "of": 3},
    }


def test_a_mission_that_sprays_more_than_it_says_or_than_the_tank_holds_is_refused():
    told = json.loads(TEXT)
    told |= {"tank": {"capacity_l": 1, "flow_l_min": 1.7}, "liquid_l": 0.9}
    assert {f.where for f in faults_of(json.dumps(told))} == {"m.json: liquid_l", "m.json: tank"}
