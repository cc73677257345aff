"""Ground heights from a GeoTIFF: of the right sign, everywhere that is flown, or refused."""

from __future__ import annotations

import math
from contextlib import suppress

import made_terrain
import numpy as np
import pytest
from made_terrain import plane, survey_text, write
from typer.testing import CliRunner

from orchard_cli import mission as missions
from orchard_cli.commands.app import app
from orchard_cli.commands.survey_input import on_terrain
from orchard_cli.errors import InputError
from orchard_cli.geometry.geodesy import wgs84_from_site
from orchard_cli.mission.inspection import inspect
from orchard_cli.mission.inspection.terrain import Terrain as Judged
from orchard_cli.model.mission import Provenance
from orchard_cli.survey import geotiff, parse

PROVENANCE = Provenance("field.survey.toml", "0" * 64, "test", "2026-01-01T00:00:00+00:00")


def planned(tif, survey=None, **flight):
    """(what there is to tell, mission) of a survey flown over a GeoTIFF, or (faults, None)."""
    text = (survey or survey_text()).encode()
    try:
        told = on_terrain(parse(text, "field.survey.toml", flight=flight), tif)
        return "; ".join(told.remarks), missions.plan(told.orchard, told.wishes, PROVENANCE)
    except InputError as error:
        return str(error), None


def site_slope(east, north, heading_deg):
    """Rise per m along x and y of a site whose x has that compass heading."""
    h = math.radians(heading_deg)
    return east * math.sin(h) + north * math.cos(h), -east * math.cos(h) + north * math.sin(h)


@pytest.mark.parametrize("epsg", [made_terrain.UTM, 4326])
@pytest.mark.parametrize(("east", "north"), [(0.1, 0.0), (-0.1, 0.0), (0.0, 0.1), (0.0, -0.1)])
def test_a_slope_has_its_sign_every_way(tmp_path, epsg, east, north):
    tif = write(tmp_path / "s.tif", plane(east, north), epsg=epsg)
    for heading in (90.0, 37.0):
        _, mission = planned(tif, survey=survey_text(heading))
        along, across = site_slope(east, north, heading)
        for row in mission.orchard.rows:
            expected = row.trunks_site @ [along, across]
            np.testing.assert_allclose(row.ground, expected, atol=0.03)  # the grid of UTM is turned
        tops = mission.waypoints_site[:, 2] - mission.waypoints_site[:, :2] @ [along, across]
        np.testing.assert_allclose(tops, 3.5, atol=0.05)


@pytest.mark.parametrize("point", [False, True])
def test_pixels_lie_where_their_keys_say(tmp_path, point):
    tif = write(tmp_path / "s.tif", plane(0.2, -0.1, level=100.0), point=point, step=10.0)
    raster = geotiff.read(tif)
    at = raster.at(np.array([[made_terrain.LATITUDE, made_terrain.LONGITUDE]]))
    assert at[0] == pytest.approx(100.0, abs=1e-3)  # half a pixel off would be 1 m


def test_the_datum_and_the_unit_of_heights_tilt_nothing(tmp_path):
    feet = write(tmp_path / "f.tif", lambda e, n: plane(0.1, 0)(e, n) / 0.3048, unit=9002)
    said, mission = planned(feet)
    assert mission.orchard.rows[0].ground[-1] == pytest.approx(1.5, abs=0.02)
    assert "another datum" not in said
    lifted = write(tmp_path / "l.tif", plane(0.1, 0, level=60.0))
    said, mission = planned(lifted)
    assert mission.orchard.rows[0].ground[-1] == pytest.approx(1.5, abs=0.02)
    assert "puts the first tree at 60.0 m, the survey at 20.0 m" in said


def mound(east, north):
    """3 m high, 4 m wide, between the third and fourth tree of the first row: no tree tells it."""
    return 20.0 + 3.0 * np.exp(-((east - 7.5) ** 2 + north**2) / 2.0)


@pytest.mark.parametrize("follow", ["line", "terrain"])
@pytest.mark.parametrize("above", ["ground", "canopy"])
def test_a_mound_between_the_trees_is_flown_over(tmp_path, follow, above):
    tif = write(tmp_path / "m.tif", mound, epsg=4326, step=0.5, reach=60.0)
    _, mission = planned(
        tif, follow=follow, height_above=above, height_m=1.5 if above == "canopy" else 6.0
    )
    over = mission.trajectory.sample(np.linspace(0, mission.trajectory.end, 2000))[0]
    clear = over[:, 2] - mound(over[:, 0], over[:, 1]) + 20.0
    assert clear.min() > mission.limits.clearance - 0.02
    assert all(finding.ok for finding in inspect(mission))


def test_check_judges_the_height_above_that_terrain(tmp_path):
    tif = write(tmp_path / "m.tif", mound, epsg=4326, step=0.5, reach=60.0)
    _, mission = planned(tif, height_m=6.0, follow="terrain")
    places = np.random.default_rng(1).uniform(-5, 20, (500, 2))
    judged = Judged(mission.orchard).ground(places)
    np.testing.assert_allclose(judged, mission.orchard.terrain.ground(places), atol=1e-9)
    assert (judged > mound(*places.T) - 20.0 - 0.03).all()  # never tells too little
    lowest = next(f for f in inspect(mission) if f.rule.name == "height above the ground")
    assert lowest.figure == pytest.approx(6.0, abs=0.1)


def test_a_flight_too_low_over_the_terrain_is_refused(tmp_path):
    def wall(east, north):  # 8 m high, across the way between the rows' ends
        return 20.0 + 8.0 * (np.abs(north - 3.0) < 1.0) * (np.abs(east - 15.0) < 3.0)

    tif = write(tmp_path / "w.tif", wall, step=0.5, reach=60.0)
    said, mission = planned(tif)
    assert mission is None
    assert "terrain: the flight passes" in said
    assert "higher" in said


def test_a_mission_on_a_terrain_comes_back_from_its_file(tmp_path):
    tif = write(tmp_path / "s.tif", plane(0.1, -0.05))
    _, mission = planned(tif)
    again = missions.loads(missions.dumps(mission))
    np.testing.assert_array_equal(again.orchard.terrain.heights, mission.orchard.terrain.heights)
    assert missions.dumps(again) == missions.dumps(mission)


def test_every_sortie_and_export_stands_on_the_terrain(tmp_path):
    tif = write(tmp_path / "s.tif", plane(0.1, 0.05))
    survey = survey_text(more="[tank]\ncapacity_l = 0.3\ndose_l_ha = 50\n")
    file, out = tmp_path / "field.survey.toml", tmp_path / "field.mission.json"
    file.write_text(survey)
    command = ["plan", str(file), "-o", str(out), "--terrain", str(tif)]
    result = CliRunner().invoke(app, [*command, "--export", str(tmp_path / "field.csv")])
    assert result.exit_code == 0, result.exception
    assert "ground from s.tif (WGS 84 / UTM zone 49N)" in result.stdout.replace("\n", " ")
    sorties = sorted(tmp_path.glob("field-*of*.mission.json"))
    assert len(sorties) == 2
    for file in sorties:
        mission = missions.load(file)
        over = mission.waypoints_site
        np.testing.assert_allclose(over[:, 2] - over[:, :2] @ [0.1, 0.05], 3.5, atol=0.05)
        assert all(finding.ok for finding in inspect(mission))
        lines = file.with_name(file.name.replace(".mission.json", ".csv")).read_text().splitlines()
        at = lines[0].split(",").index("height_above_ground_m")
        heights = np.array([float(line.split(",")[at]) for line in lines[1:]])
        np.testing.assert_allclose(heights[1:-1], 3.5, atol=0.15)


def test_known_obstacles_stand_on_the_terrain(tmp_path):
    tif = write(tmp_path / "s.tif", plane(0.1, 0.0))
    pole = "[[obstacle]]\nx_m = 30.0\ny_m = 20.0\nradius_m = 0.2\nheight_m = 8.0\n"
    _, mission = planned(tif, survey=survey_text(more=pole))
    assert mission.orchard.obstacles[0].top == pytest.approx(11.0, abs=0.05)
    said, mission = planned(tif, survey=survey_text(more=pole + "ground_m = -3.0\n"))
    assert mission is None
    assert "obstacle 1, pole: the survey says ground_m = -3.00, the terrain 2.97" in said


def test_ground_that_was_measured_otherwise_is_refused(tmp_path):
    tif = write(tmp_path / "s.tif", plane(0.1, 0.0))
    rows = survey_text().replace("tree_height_m = 2.0", "tree_height_m = 2.0\nground_m = -2.0", 1)
    said, mission = planned(tif, survey=rows)
    assert mission is None
    assert "row 1, tree 6: the survey says ground_m = -2.00, the terrain 1.50" in said


@pytest.mark.filterwarnings("ignore:.*stored as RGB")
@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda p: write(p, plane(0, 0), reach=30.0), "does not reach"),
        (lambda p: write(p, lambda e, n: np.where(e > 10, -9999, 20), nodata=-9999), "no data at"),
        (lambda p: write(p, lambda e, n: np.where(e > 10, np.nan, 20)), "no data at"),
        (lambda p: write(p, lambda e, n: np.where(e > 10, -32768, 20)), "no height of the earth"),
        (lambda p: write(p, plane(0, 0), unit=9042), "heights in unit EPSG:9042"),
        (lambda p: write(p, lambda e, n: e[..., None] * [1, 2, 3]), "has 3 bands"),
        (lambda p: write(p, plane(0, 0), dtype=np.complex64), "no heights"),
        (lambda p: p.write_bytes(b"II*\0" + b"\xff" * 64), "is no GeoTIFF"),
        (lambda p: p.write_bytes(b""), "is no GeoTIFF"),
        (lambda p: made_terrain.tifffile.imwrite(p, np.zeros((9, 9), np.float32)), "where it"),
        (lambda p: p.mkdir(), "is no regular file"),
    ],
)  # fmt: skip
def test_a_terrain_that_does_not_do_is_refused_in_one_line(tmp_path, make, told):
    tif = tmp_path / "t.tif"
    make(tif)
    said, mission = planned(tif)
    assert mission is None
    assert told in said
    assert "\n" not in said.strip()


@pytest.mark.parametrize("compression", ["zlib", "lzw"])
@pytest.mark.parametrize("predictor", [None, 3])
def test_packed_files_are_read_as_plain_ones(tmp_path, compression, predictor):
    tif = write(
        tmp_path / "p.tif", plane(0.1, 0.2), compression=compression, predictor=predictor,
        tile=(32, 32),
    )  # fmt: skip
    plain = geotiff.read(write(tmp_path / "q.tif", plane(0.1, 0.2)))
    np.testing.assert_array_equal(geotiff.read(tif).heights, plain.heights)


def test_a_cut_or_changed_file_is_refused_or_read(tmp_path):
    whole = write(tmp_path / "s.tif", plane(0.1, 0.0), reach=20, compression="zlib").read_bytes()
    rng = np.random.default_rng(3)
    for _ in range(150):
        data = bytearray(whole[: rng.integers(1, len(whole))])
        for at in rng.integers(0, len(data), 8):
            data[at] = rng.integers(0, 256)
        (tmp_path / "x.tif").write_bytes(data)
        with suppress(InputError):  # and nothing else
            geotiff.read(tmp_path / "x.tif")


def test_heights_on_earth_are_the_rasters(tmp_path):
    """From the first tree up: the mission's places, read back from the raster, keep the height."""
    tif = write(tmp_path / "s.tif", plane(0.08, -0.06))
    _, mission = planned(tif)
    raster = geotiff.read(tif)
    places = wgs84_from_site(mission.orchard.origin, mission.waypoints_site)
    above = places[:, 2] - raster.at(places)
    np.testing.assert_allclose(above, 3.5, atol=0.02)
