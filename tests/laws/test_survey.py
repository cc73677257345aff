"""Surveys: what is read is what was measured, and every fault is told, with its place and mend."""

from __future__ import annotations

import csv
import io
import math
import os
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli import survey
from orchard_cli.errors import InputError
from orchard_cli.model.site import HeightReference
from orchard_cli.model.wishes import HeightAbove, StartRow, StartSide
from orchard_cli.survey import Form

GOOD = """
[site]
latitude_deg = 23.45
longitude_deg = 113.2
height_m = 20.0
heading_deg = 90.0

[flight]
height_m = 3.5

[[row]]
gaps_m = [3.0, 2.5]
tree_height_m = 2.0

[[row]]
distance_m = 6.0
start_m = 0.5
gaps_m = [3.0, 4.0, 2.5]
tree_height_m = [2.0, 2.1, 2.2, 2.3]
ground_m = 0.1
"""

SHEET = """\
# name = "sheet"
# [site]
# latitude_deg = 23.45
# longitude_deg = 113.2
# height_m = 20.0
# heading_deg = 90.0
# [flight]
# height_m = 3.5
row,distance_m,start_m,gap_m,tree_height_m,ground_m
1,,,,2.0,
1,,,3.0,2.0,
1,,,2.5,2.0,
2,6.0,0.5,,2.0,0.1
2,,,3.0,2.1,0.1
2,,,4.0,2.2,0.1
2,,,2.5,2.3,0.1
"""


def faults_of(text, csv=False):
    data = text if isinstance(text, bytes) else text.encode()
    with pytest.raises(InputError) as caught:
        survey.parse(data, "f.csv" if csv else "f.toml", Form.SHEET if csv else Form.TOML)
    return caught.value.faults


def only_fault(text, csv=False):
    (fault,) = faults_of(text, csv)
    return fault


def test_rows_stand_where_the_tape_says():
    orchard = survey.parse(GOOD.encode(), "f.toml").orchard
    first, second = orchard.rows
    assert first.trunks_site.tolist() == [[0, 0], [3, 0], [5.5, 0]]
    assert second.trunks_site == pytest.approx(np.array([[0.5, 6], [3.5, 6], [7.5, 6], [10, 6]]))
    assert first.heights.tolist() == [2.0] * 3
    assert second.heights.tolist() == [2.0, 2.1, 2.2, 2.3]
    assert second.ground.tolist() == [0.1] * 4
    assert orchard.origin.heading == math.radians(90)
    assert orchard.origin.height_reference is HeightReference.AMSL


def test_rows_measured_at_both_ends_need_not_be_parallel():
    text = GOOD.replace("distance_m = 6.0", "distance_m = 6.0\nfar_distance_m = 7.0")
    trunks = survey.parse(text.encode(), "f").orchard.rows[1].trunks_site
    assert np.hypot(*np.diff(trunks, axis=0).T) == pytest.approx([3.0, 4.0, 2.5])
    assert trunks[0] == pytest.approx([0.5, 6.0])
    assert trunks[-1, 1] == pytest.approx(7.0, abs=0.01)


def test_every_wish_and_limit_is_read():
    text = GOOD.replace(
        "[flight]\nheight_m = 3.5",
        """[flight]
height_m = 1.5
height_above = "canopy"
speed_m_s = 2.0
acceleration_m_s2 = 0.6
acceleration_along_m_s2 = 0.3
yaw_rate_rad_s = 0.7
climb_speed_m_s = 0.9
swath_m = 2.5
start_row = "last"
start_side = "far"
corner_cut_m = 0.4
takeoff_m = [-5, 1]
landing_m = [20, 1]
[vehicle]
clearance_m = 1.1
airframe_radius_m = 0.4
endurance_s = 500
reserve = 0.3""",
    )
    wishes = survey.parse(text.encode(), "f").wishes
    assert (wishes.height, wishes.height_above) == (1.5, HeightAbove.CANOPY)
    assert (wishes.start_row, wishes.start_side) == (StartRow.LAST, StartSide.FAR)
    assert (wishes.swath, wishes.corner_cut) == (2.5, 0.4)
    assert wishes.takeoff_site.tolist() == [-5, 1]
    assert wishes.landing_site.tolist() == [20, 1]
    limits = wishes.limits
    assert (limits.speed, limits.acceleration, limits.acceleration_along) == (2.0, 0.6, 0.3)
    assert (limits.yaw_rate, limits.climb_speed) == (0.7, 0.9)
    assert (limits.clearance, limits.airframe_radius) == (1.1, 0.4)
    assert (limits.endurance, limits.reserve) == (500, 0.3)


def test_obstacles_fence_and_keep_outs_keep_their_geometry():
    """PEERS.md: inner boundaries and columns lost or swapped on import."""
    text = (
        GOOD
        + """
[[obstacle]]
name = "mast"
x_m = 4.0
y_m = 6.5
radius_m = 0.2
height_m = 9.0
ground_m = 0.5
[fence]
points_m = [[-10, -11], [30, -12], [31, 20], [-9, 21]]
[[keep_out]]
points_m = [[1, 2], [3, 2], [3, 4]]
[[keep_out]]
points_m = [[11, 2], [13, 2], [13, 4], [11, 5]]
"""
    )
    orchard = survey.parse(text.encode(), "f").orchard
    (mast,) = orchard.obstacles
    assert (mast.name, mast.position_site.tolist(), mast.radius, mast.top) == (
        "mast", [4.0, 6.5], 0.2, 9.5,
    )  # fmt: skip
    assert orchard.fence_site.tolist() == [[-10, -11], [30, -12], [31, 20], [-9, 21]]
    assert [ring.tolist() for ring in orchard.keep_outs_site] == [
        [[1, 2], [3, 2], [3, 4]],
        [[11, 2], [13, 2], [13, 4], [11, 5]],
    ]


@pytest.mark.parametrize(
    ("separator", "decimal"), [(",", "."), (";", "."), (";", ","), ("\t", ",")]
)
def test_a_sheet_tells_the_same_orchard_as_toml(separator, decimal):
    head, body = SHEET.split("row,", 1)
    body = ("row," + body).replace(",", "|").replace(".", decimal).replace("|", separator)
    sheet = survey.parse((head + body).encode(), "f.csv", form=Form.SHEET).orchard
    toml = survey.parse(GOOD.encode(), "f.toml").orchard
    assert sheet.name == "sheet"
    assert sheet.origin == toml.origin
    for a, b in zip(sheet.rows, toml.rows, strict=True):
        assert a.trunks_site == pytest.approx(b.trunks_site)
        assert a.heights.tolist() == b.heights.tolist()
        assert a.ground.tolist() == b.ground.tolist()


def through_a_spreadsheet(text, separator):
    """The sheet as a spreadsheet that was told of this separator saves it: padded and quoted."""
    rows = [line.split(separator) for line in text.splitlines()]
    out = io.StringIO()
    writer = csv.writer(out, delimiter=separator, lineterminator="\r\n")
    writer.writerows(row + [""] * (6 - len(row)) for row in rows)
    return out.getvalue()


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_sheet_that_a_spreadsheet_saved_tells_the_same(separator):
    head, body = SHEET.split("row,", 1)
    head += "# takeoff_m = [-6.0, 0.5]\n# [fence]\n# points_m = [[-20, -20],\n# [60, -20],\n"
    head += "# [60, 60], [-20, 60]]\n\n"
    text = head + ("row," + body).replace(",", separator)
    saved = through_a_spreadsheet(text, separator)
    assert '"# name = ""sheet"""' + 5 * separator in saved
    before = survey.parse(text.encode(), "f.csv", form=Form.SHEET)
    after = survey.parse(saved.encode(), "f.csv", form=Form.SHEET)
    assert after.orchard.name == "sheet"
    assert after.wishes.takeoff_site.tolist() == [-6.0, 0.5]
    assert after.orchard.fence_site.tolist() == before.orchard.fence_site.tolist()
    assert len(after.orchard.fence_site) == 4
    assert after.orchard.origin == before.orchard.origin
    assert [len(row.heights) for row in after.orchard.rows] == [3, 4]


def test_columns_may_be_written_in_capitals():
    first, rest = SHEET.split("\n1,", 1)
    head, columns = first.rsplit("\n", 1)
    assert survey.parse(f"{head}\n{columns.upper()}\n1,{rest}".encode(), "f.csv", form=Form.SHEET)


def test_a_sheet_without_its_head_is_told_how_to_write_one():
    site, flight = faults_of("row," + SHEET.split("row,", 1)[1], csv=True)
    assert (site.where, flight.where) == ("f.csv: site", "f.csv: flight")
    assert '"# [site]", then its keys, like "# latitude_deg = 23.45"' in site.mend
    assert '"# [flight]", then its keys, like "# height_m = 3.5"' in flight.mend


@pytest.mark.parametrize("name", ["a\\u001b[2Jb", "a\\nb", "a\\u202eb"])
def test_a_name_with_control_characters_is_refused(name):
    fault = only_fault(f'name = "{name}"\n' + GOOD)
    assert fault.where == "f.toml: name"
    assert str(fault).isprintable()


def test_a_name_may_be_of_any_script():
    name = "柠檬园\u3000北 Été"
    assert survey.parse(f'name = "{name}"\n{GOOD}'.encode(), "f").orchard.name == name


def test_a_missing_table_is_one_fault_not_one_a_key():
    fault = only_fault(GOOD.replace("[flight]\nheight_m = 3.5\n", ""))
    assert (fault.where, fault.what) == ("f.toml: flight", "the table is missing")


gaps = st.lists(st.floats(0.5, 9), min_size=1, max_size=30)


@given(st.lists(st.tuples(gaps, st.floats(1, 9), st.floats(-20, 20)), min_size=1, max_size=6))
@settings(max_examples=50, deadline=None, derandomize=True)
def test_tape_measurements_come_back_from_the_trunks(rows):
    text = GOOD.split("[[row]]", maxsplit=1)[0]
    for k, (row_gaps, distance, start) in enumerate(rows):
        text += f"[[row]]\ngaps_m = {row_gaps}\ntree_height_m = 2\n"
        text += f"distance_m = {distance}\nstart_m = {start}\n" if k else ""
    laid = survey.parse(text.encode(), "f").orchard.rows
    assert laid[0].trunks_site[0].tolist() == [0, 0]
    for k, (row_gaps, distance, start) in enumerate(rows):
        trunks = laid[k].trunks_site
        assert np.hypot(*np.diff(trunks, axis=0).T) == pytest.approx(row_gaps)
        if k:
            assert trunks[0, 0] == pytest.approx(start)
            assert trunks[0, 1] - laid[k - 1].trunks_site[0, 1] == pytest.approx(distance)


@pytest.mark.parametrize(
    ("old", "new", "where", "what"),
    [
        ("[3.0, 2.5]", "[3.0, -2.5]", "row 1: gaps_m[2]", "-2.5"),
        ("[3.0, 2.5]", "[3.0, 0]", "row 1: gaps_m[2]", "is 0"),
        ("[3.0, 2.5]", "[3.0, nan]", "row 1: gaps_m[2]", "nan"),
        ("[3.0, 2.5]", "[3.0, inf]", "row 1: gaps_m[2]", "inf"),
        ("[3.0, 2.5]", '[3.0, "2.5"]', "row 1: gaps_m[2]", "not a number"),
        ("[3.0, 2.5]", "[3.0, true]", "row 1: gaps_m[2]", "not a number"),
        ("[3.0, 2.5]", "[]", "row 1: gaps_m", "[]"),
        ("[3.0, 2.5]", "3.0", "row 1: gaps_m", "3.0"),
        ("distance_m = 6.0", "distance_m = -6.0", "row 2: distance_m", "-6.0"),
        ("distance_m = 6.0", "distance_m = 0", "row 2: distance_m", "is 0"),
        ("distance_m = 6.0", "", "row 2: distance_m", "missing"),
        ("distance_m = 6.0", "distance_m = 0.2", "row 2", "coincides with row 1"),
        (
            "distance_m = 6.0", "distance_m = 6.0\nfar_distance_m = -1", "row 2: far_distance_m",
            "-1",
        ),
        ("2.1, 2.2, 2.3]", "2.1]", "row 2: tree_height_m", "2 numbers for 4 trees"),
        ("latitude_deg = 23.45", "latitude_deg = 95", "site: latitude_deg", "95"),
        ("latitude_deg = 23.45", "latitude_deg = nan", "site: latitude_deg", "nan"),
        ("latitude_deg = 23.45", "latitude_deg = 1" + "0" * 400, "site: latitude_deg", "1000"),
        ("latitude_deg = 23.45", "latitud_deg = 23.45\nlatitude_deg = 1", "site: latitud_deg",
         "not known"),
        ("height_m = 3.5", "", "flight: height_m", "missing"),
        ("height_m = 3.5", "height_m = 3\nheight_above = 'trees'", "flight: height_above", "trees"),
        ("height_m = 3.5", "height_m = 3.5\ntakeoff_m = [1]", "flight: takeoff_m", "[1]"),
        ("height_m = 3.5", "height_m = 3.5\n[vehicle]\nclearance_m = 0.2", "vehicle: clearance_m",
         "less than the airframe"),
        ("[flight]", "[fence]\npoints_m = [[0, 0], [9, 9], [9, 0], [0, 9]]\n[flight]",
         "fence: points_m", "crosses itself"),
        ("[flight]", "[fence]\npoints_m = [[0, 0], [9, 9]]\n[flight]", "fence: points_m", "poly"),
    ],
)  # fmt: skip
def test_a_fault_is_told_with_its_place(old, new, where, what):
    assert old in GOOD
    fault = only_fault(GOOD.replace(old, new, 1))
    assert fault.where == f"f.toml: {where}"
    assert what in fault.what
    assert fault.mend


def test_rows_that_cross_are_refused():
    """Row 2 is long and converges; row 3 is measured beside its far end and runs into it."""
    text = (
        GOOD.split("[[row]]", maxsplit=1)[0]
        + """
[[row]]
gaps_m = [10, 10, 10]
tree_height_m = 2
[[row]]
distance_m = 9
far_distance_m = 1
gaps_m = [2, 2]
tree_height_m = 2
[[row]]
distance_m = 2
start_m = -4
gaps_m = [10, 10, 10]
tree_height_m = 2
"""
    )
    assert any("crosses row" in fault.what for fault in faults_of(text))


def test_all_faults_are_told_together():
    text = GOOD.replace("23.45", "99").replace("2.5]", "-1]", 1).replace("swath", "swat")
    text = text.replace("height_m = 3.5", "height_m = 3.5\nswat_m = 2\nspeed_m_s = 'fast'")
    assert {f.where.removeprefix("f.toml: ") for f in faults_of(text)} == {
        "site: latitude_deg", "row 1: gaps_m[2]", "flight: swat_m", "flight: speed_m_s",
    }  # fmt: skip
    assert any(f.mend == "did you mean swath_m?" for f in faults_of(text))


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"", "empty"),
        (b" \n\n", "empty"),
        (GOOD.encode() + b"# caf\xe9", "not UTF-8"),
        (b"\xff\xfe" + GOOD.encode("utf-16-le"), "not UTF-8"),
        (b"[site\n", "not TOML"),
        (b"\x00\x01", "not TOML"),
        (b"a = " + b"[" * 5000, "nested too deeply"),
        (b"a = 1" + b"0" * 5000, "not TOML"),
        (b"[[row]]\ngaps_m=[1]\n" * 30_000, "30000 rows"),
    ],
)
def test_what_is_no_survey_is_refused(data, what):
    assert what in only_fault(data).what


def test_a_byte_order_mark_is_no_fault():
    assert survey.parse(b"\xef\xbb\xbf" + GOOD.encode(), "f").orchard.rows


def test_a_million_rows_are_refused_unread(tmp_path):
    path = tmp_path / "many.toml"
    with path.open("w") as file:
        for _ in range(1000):
            file.write("[[row]]\ngaps_m = [3.0]\ntree_height_m = 2\n" * 1000)
    with pytest.raises(InputError, match="MB is the most"):
        survey.load(path)


@pytest.mark.parametrize("name", ["nowhere.toml", ".", "pipe"])
def test_what_is_no_file_is_refused(tmp_path, name):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match=r"is no (regular )?file"):
        survey.load(Path(tmp_path / name))


@pytest.mark.parametrize(
    ("old", "new", "where", "what"),
    [
        ("1,,,3.0,2.0,", "1,,,-3.0,2.0,", "line 11: gap_m", "-3.0"),
        ("1,,,3.0,2.0,", "1,,,,2.0,", "line 11: gap_m", "missing"),
        ("1,,,3.0,2.0,", "1,,,x,2.0,", "line 11: gap_m", "not a number"),
        ("1,,,3.0,2.0,", "1,,,3.0,2.0,,7", "line 11", "7 cells for 6 columns"),
        ("1,,,3.0,2.0,", "1,4,,3.0,2.0,", "line 11: distance_m", "first line"),
        ("1,,,,2.0,", "1,,,2,2.0,", "line 10: gap_m", "first line"),
        ("2,6.0,0.5,,2.0,0.1", "3,6.0,0.5,,2.0,0.1", "line 13: row", "3 after row 1"),
        ("gap_m,", "gaps_m,", "line 9", "no column gap_m"),
    ],
)
def test_a_fault_of_a_sheet_is_told_with_its_line(old, new, where, what):
    assert old in SHEET
    found = faults_of(SHEET.replace(old, new, 1), csv=True)
    assert found[0].where == f"f.csv: {where}"
    assert what in found[0].what


def test_a_sheet_with_rows_of_one_tree_is_refused():
    text = SHEET.split("2,6.0", maxsplit=1)[0] + "2,6.0,,,2.0,\n"
    assert "one tree" in only_fault(text, csv=True).what


@given(st.binary(max_size=300), st.booleans())
@settings(max_examples=150, deadline=None, derandomize=True)
def test_no_bytes_make_it_fail_in_another_way(data, csv):
    with suppress(InputError):
        survey.parse(data, "f", form=Form.SHEET if csv else Form.TOML)


@given(st.data())
@settings(max_examples=150, deadline=None, derandomize=True)
def test_no_mutilated_survey_makes_it_fail_in_another_way(data):
    text = data.draw(st.sampled_from([GOOD, SHEET]))
    at = data.draw(st.integers(0, len(text) - 1))
    put = data.draw(
        st.sampled_from(["", "-", "nan", "1e999", "[", "]", '"', "=", "\n", ",", "9" * 50])
    )
    cut = data.draw(st.integers(0, 12))
    with suppress(InputError):
        survey.parse(
            (text[:at] + put + text[at + cut :]).encode(),
            "f",
            form=Form.SHEET if text is SHEET else Form.TOML,
        )
