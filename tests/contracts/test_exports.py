"""Exports: what other tools read from them is the mission, to a centimetre.

Each file is read back by its own reader and, beside it, by a reader that this project did not
write. Geometry is compared, never counts alone.
"""

from __future__ import annotations

import csv
import dataclasses
import io
import json
import subprocess
import sys
import zipfile
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import shapely

from orchard_cli import mission as missions
from orchard_cli.errors import InputError
from orchard_cli.geometry.geodesy import site_from_wgs84
from orchard_cli.mission.exports import (
    Format,
    Pump,
    PumpBy,
    course,
    differences,
    export,
    is_own,
    read,
)
from orchard_cli.model.mission import Leg
from orchard_cli.model.site import HeightReference, KnownObstacle, Orchard, SiteOrigin
from tests.laws.test_mission import plan, row

MISSIONS = Path(__file__).parents[2] / "missions"
MACHINE = [form for form in Format if not form.is_picture]
PICTURES = [form for form in Format if form.is_picture]


@cache
def hill(south: bool = False):
    """A slope with a fence, two keep-outs and a pole, by ellipsoidal heights."""
    origin = SiteOrigin(47.4, 8.5, 430.0, HeightReference.ELLIPSOID, np.radians(40.0))
    if south:
        origin = SiteOrigin(-33.9, -70.6, 520.0, HeightReference.AMSL, np.radians(260.0))
    what = Orchard(
        "hill",
        origin,
        (row(0, slope=0.08), row(5, 0.5, slope=0.08), row(10, slope=0.08)),
        obstacles=(KnownObstacle(np.array([20.0, 5.0]), 0.2, 9.0, "mast <&>"),),
        fence_site=[[-10, -8], [40, -8], [40, 18], [12, 25], [-10, 18]],
        keep_outs_site=(
            np.array([[24, 1], [30, 1], [30, 5], [27, 3]], dtype=float),
            np.array([[24, 9], [30, 9], [28, 12]], dtype=float),
        ),
    )
    return plan(what)


@cache
def flat():
    return missions.load(MISSIONS / "lemon-field.mission.json")


ALL = [flat, hill, lambda: hill(south=True)]


@pytest.mark.parametrize("form", MACHINE)
@pytest.mark.parametrize("make", ALL)
def test_read_back_it_is_the_same_to_a_centimetre(form, make):
    mission = make()
    way = course(mission)
    loaded = read(export([mission], form), form)
    assert differences(way, loaded) == []
    assert loaded.sprays == tuple(leg.sprays for leg in way.ways)
    assert sum(loaded.sprays) == len(mission.orchard.rows)


def test_the_course_is_the_mission_s_route_with_its_ends():
    mission = hill()
    way = course(mission)
    for waypoint in mission.waypoints_site:
        assert np.abs(way.points_site - waypoint).max(axis=1).min() < 1e-9
    assert way.points_site[0, :2] == pytest.approx(mission.takeoff_site)
    assert way.points_site[-1, :2] == pytest.approx(mission.landing_site)
    path = mission.trajectory.sample(np.arange(0, mission.trajectory.end, 0.1))[0]
    line = shapely.LineString(way.points_site[:, :2])
    beside = shapely.distance(line, shapely.points(path[:, :2]))
    assert beside.max() < mission.corner_cut + 0.1


def site_of(mission, places_wgs84, heights):
    """Back to the site frame, by heights above the ground at take-off."""
    places = np.asarray(places_wgs84, dtype=float)
    above = np.asarray(heights, dtype=float) + mission.takeoff_ground
    level = site_from_wgs84(
        mission.orchard.origin,
        np.column_stack([places[:, :2], mission.orchard.origin.height + above]),
    )
    return np.column_stack([level[:, :2], above])


def same(mission, places, heights):
    found = site_of(mission, places, heights)
    assert found == pytest.approx(course(mission).points_site, abs=0.01)


@pytest.mark.parametrize("make", ALL)
def test_wpl_is_what_mavproxy_s_loader_reads(make, tmp_path):
    from pymavlink import mavwp

    mission = make()
    path = tmp_path / "a.waypoints"
    path.write_bytes(export([mission], Format.WPL))
    loader = mavwp.MAVWPLoader()
    loader.load(str(path))
    items = [loader.wp(k) for k in range(1, loader.count())]
    flown = [item for item in items if item.command in (16, 22)]
    assert {item.frame for item in flown} == {3}
    same(mission, [(i.x, i.y) for i in flown], [i.z for i in flown])
    home = loader.wp(0)
    assert home.z == pytest.approx(mission.orchard.origin.height + mission.takeoff_ground, abs=0.01)


@pytest.mark.parametrize("make", ALL)
def test_plan_has_simple_items_and_the_fence_as_polygons(make):
    """Complex items are dropped unsaid by other tools (MAVSDK #1116, #1163); holes are exclusion
    polygons (QGroundControl #6969, #7100)."""
    mission = make()
    told = json.loads(export([mission], Format.PLAN))
    items = told["mission"]["items"]
    assert {item["type"] for item in items} == {"SimpleItem"}
    assert [item["doJumpId"] for item in items] == list(range(1, len(items) + 1))
    flown = [item for item in items if item["command"] in (16, 22)]
    assert {item["frame"] for item in flown} == {3}
    assert all(item["params"][6] == item["Altitude"] for item in flown)
    same(mission, [i["params"][4:6] for i in flown], [i["params"][6] for i in flown])
    orchard = mission.orchard
    rings = [orchard.fence_site] if len(orchard.fence_site) else []
    rings += list(orchard.keep_outs_site)
    polygons = told["geoFence"]["polygons"]
    assert [p["inclusion"] for p in polygons] == [True] * (len(rings) > 0) + [False] * (
        len(rings) - 1 if rings else 0
    )
    for ring, polygon in zip(rings, polygons, strict=True):
        corners = site_of(mission, polygon["polygon"], np.zeros(len(ring)))
        assert corners[:, :2] == pytest.approx(ring, abs=0.01)


@pytest.mark.parametrize("make", ALL)
def test_geojson_is_what_shapely_reads(make):
    mission = make()
    told = json.loads(export([mission], Format.GEOJSON))
    shapes = [(f["properties"], shapely.geometry.shape(f["geometry"])) for f in told["features"]]
    legs = [s for p, s in shapes if p["kind"] == "leg"]
    points = np.array([legs[0].coords[0], *(leg.coords[1] for leg in legs)])
    home = mission.orchard.origin.height + mission.takeoff_ground
    same(mission, points[:, 1::-1], points[:, 2] - home)
    fences = [s for p, s in shapes if p["kind"] == "fence"]
    assert all(f.exterior.is_ccw for f in fences)
    trees = [s for p, s in shapes if p["kind"] == "tree"]
    trunks = np.concatenate([r.trunks_site for r in mission.orchard.rows])
    found = site_of(mission, [(t.y, t.x) for t in trees], np.zeros(len(trees)))[:, :2]
    assert found == pytest.approx(trunks, abs=0.01)


@pytest.mark.parametrize("make", ALL)
def test_kml_is_what_fastkml_reads_and_says_what_its_heights_are(make):
    fastkml = pytest.importorskip("fastkml")
    mission = make()
    text = export([mission], Format.KML).decode()
    document = fastkml.KML.from_string(text.split("?>", 1)[1])
    marks = list(fastkml.utils.find_all(document, of_type=fastkml.Placemark))
    lines = [m for m in marks if m.geometry is not None and m.geometry.geom_type == "LineString"]
    points = np.array([lines[0].geometry.coords[0], *(m.geometry.coords[1] for m in lines)])
    way = course(mission)
    absolute = mission.orchard.origin.height_reference is HeightReference.AMSL
    assert ("<altitudeMode>absolute<" in text) is absolute
    assert ("<altitudeMode>relativeToGround<" in text) is not absolute
    heights = (
        points[:, 2] - way.home_wgs84[2] if absolute else points[:, 2] - way.clear + way.heights
    )
    same(mission, points[:, 1::-1], heights)


@pytest.mark.parametrize("make", ALL)
def test_wpml_has_the_geometry_in_both_of_its_files(make):
    mission = make()
    archive = zipfile.ZipFile(io.BytesIO(export([mission], Format.WPML)))
    assert archive.namelist() == ["wpmz/template.kml", "wpmz/waylines.wpml"]
    names = {"k": "http://www.opengis.net/kml/2.2", "w": "http://www.dji.com/wpmz/1.0.2"}
    for name, key in (("wpmz/template.kml", "height"), ("wpmz/waylines.wpml", "executeHeight")):
        marks = ElementTree.fromstring(archive.read(name)).findall(".//k:Placemark", names)
        at = [m.find("k:Point/k:coordinates", names).text.split(",") for m in marks]
        heights = [float(m.find(f"w:{key}", names).text) for m in marks]
        same(mission, [(float(lat), float(lon)) for lon, lat in at], heights)


@pytest.mark.parametrize("make", ALL)
def test_csv_tells_site_and_earth_alike(make):
    mission = make()
    lines = list(csv.DictReader(io.StringIO(export([mission], Format.CSV).decode())))
    same(
        mission,
        [(float(x["latitude_deg"]), float(x["longitude_deg"])) for x in lines],
        [float(x["height_above_takeoff_m"]) for x in lines],
    )
    site = [[float(x[k]) for k in ("x_m", "y_m", "z_m")] for x in lines]
    assert site == pytest.approx(course(mission).points_site, abs=1e-3)
    assert {x["height_reference"] for x in lines} == {mission.orchard.origin.height_reference.value}


@pytest.mark.parametrize("by", PumpBy)
def test_the_pump_is_off_on_transit_headland_and_at_the_end(by):
    """ArduPilot #28684: the pump was left running on transit."""
    mission = hill()
    items = json.loads(export([mission], Format.PLAN, Pump(by, 1 if by is PumpBy.ACTUATOR else 9)))[
        "mission"
    ]["items"]
    command = {PumpBy.SPRAYER: 216, PumpBy.SERVO: 183, PumpBy.ACTUATOR: 187}[by]

    def turns_on(item):
        value = item["params"][1] if by is PumpBy.SERVO else item["params"][0]
        return value == {PumpBy.SPRAYER: 1, PumpBy.SERVO: 1900, PumpBy.ACTUATOR: 1}[by]

    on, before, states = None, None, []
    for item in items:
        if item["command"] == command:
            on = turns_on(item)
        elif item["command"] in (16, 22):
            if before is not None:
                states.append(on)
            before = item
    assert states == [leg.leg is Leg.ROW for leg in course(mission).ways]
    assert [item["command"] for item in items[:2]] == [22, command]
    assert not turns_on(items[1])
    assert [item["command"] for item in items[-2:]] == [command, 21]
    assert not turns_on(items[-2])


def test_px4_is_left_to_choose_its_own_yaw():
    text = export([flat()], Format.WPL, Pump(PumpBy.ACTUATOR, 1)).decode()
    waypoints = [line.split("\t") for line in text.splitlines()[2:] if "\t16\t" in line]
    assert {cells[7] for cells in waypoints} == {"nan"}


@pytest.mark.parametrize(
    "spoil",
    [
        lambda x: dataclasses.replace(x, places_wgs84=x.places_wgs84[:, ::-1]),
        lambda x: dataclasses.replace(x, places_wgs84=x.places_wgs84 + 1.5e-7),
        lambda x: dataclasses.replace(x, heights=x.heights + 0.02),
        lambda x: dataclasses.replace(x, sprays=tuple(not s for s in x.sprays)),
        lambda x: dataclasses.replace(x, places_wgs84=x.places_wgs84[:-1]),
        lambda x: dataclasses.replace(x, places_wgs84=x.places_wgs84[::-1]),
        lambda x: dataclasses.replace(x, fence_wgs84=x.fence_wgs84[1:]),
        lambda x: dataclasses.replace(x, keep_outs_wgs84=x.keep_outs_wgs84[:1]),
        lambda x: dataclasses.replace(x, keep_outs_wgs84=x.keep_outs_wgs84[::-1]),
    ],
)
def test_lost_or_swapped_boundaries_and_columns_are_seen(spoil):
    """AgOpen family: inner boundaries and columns lost or swapped on import, unnoticed."""
    way = course(hill())
    loaded = read(export([hill()], Format.PLAN), Format.PLAN)
    assert differences(way, loaded) == []
    assert differences(way, spoil(loaded))


@pytest.mark.parametrize("form", MACHINE)
@pytest.mark.parametrize("data", [b"", b"\x00\xff\n", b"{}", b"<kml/>", b"QGC WPL 110\n1\t2\n"])
def test_what_is_no_export_is_refused(form, data):
    assert not is_own(data, form)
    with pytest.raises(InputError):
        read(data, form)


@pytest.mark.parametrize("form", list(Format))
def test_an_export_may_be_written_over_by_another(form):
    assert is_own(export([flat()], form), form)


@pytest.mark.parametrize("form", [Format.SVG, Format.HTML])
def test_pictures_need_nothing_from_elsewhere(form):
    text = export([hill()], form).decode()
    for word in ("http://www.w3.org/2000/svg", "http://www.w3.org/1999/xhtml"):
        text = text.replace(word, "")
    assert "http" not in text
    assert "mast &lt;&amp;&gt;" in text


def test_the_png_is_one():
    assert export([flat()], Format.PNG).startswith(b"\x89PNG\r\n")


def orchard(*arguments):
    return subprocess.run(
        [sys.executable, "-c", "from orchard_cli.commands import main; main()", *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_the_command_writes_by_the_file_s_ending_and_over_exports_alone(tmp_path):
    mission, out = str(MISSIONS / "lemon-field.mission.json"), tmp_path / "a.plan"
    done = orchard("export", mission, "-o", str(out), "--json")
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout) == {
        "file": str(out), "format": "plan", "bytes": out.stat().st_size,
    }  # fmt: skip
    assert orchard("export", mission, "-o", str(out), "-q").returncode == 0
    out.write_text("a survey", encoding="utf-8")
    done = orchard("export", mission, "-o", str(out))
    assert done.returncode == 2
    assert "is there already" in done.stderr
    assert out.read_text(encoding="utf-8") == "a survey"


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["-o", "a.xyz"], "names no format"),
        (["-o", "a.plan", "--format", "shapefile"], "--format"),
        (["-o", "a.plan", "--pump", "hose"], "--pump"),
        (["-o", "a.plan", "--pump", "actuator", "--pump-number", "7"], "--pump-number"),
        (["-o", "no/such/folder/a.plan"], "cannot be written"),
    ],
)
def test_wrong_options_are_one_line(arguments, word, tmp_path):
    arguments = [str(tmp_path / a) if a.endswith((".plan", ".xyz")) else a for a in arguments]
    done = orchard("export", str(MISSIONS / "lemon-field.mission.json"), *arguments)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert word in line
