"""Drawn surveys: what is drawn is what is flown; geometry is compared, never counts alone."""

from __future__ import annotations

import io
import json
import math
import zipfile
from functools import cache
from importlib import resources
from pathlib import Path

import fastkml
import numpy as np
import pygeoif
import pytest
import shapely
from jsonschema import Draft202012Validator
from made_surveys import (
    collection,
    csv_degrees,
    csv_metres,
    degrees,
    feature,
    geojson_trees,
    kml,
    kml_mark,
    kml_trees,
    point,
)

from orchard_cli import mission, survey
from orchard_cli.errors import InputError
from orchard_cli.model.mission import Provenance
from orchard_cli.survey import Form, Given

MISSIONS = Path(__file__).parents[2] / "missions"
FIELD = survey.load(MISSIONS / "lemon-field.survey.toml")
HEAD = """\
# [site]
# latitude_deg = 23.45
# longitude_deg = 113.13333
# height_m = 40.0
# heading_deg = 75.0
"""
NOBODY = Provenance("", "", "", "")
SETTINGS = {key: FIELD.tables[key] for key in ("flight", "vehicle")}
HIGH = Given(ground_height_m=40.0)
GROUND = Given(ground_height_m=40.0, settings=SETTINGS)
OUTER = [[-10, -10], [60, -10], [60, 40], [-10, 40]]
POND = [[5, 5.5], [9, 5.5], [9, 8.5], [5, 8.5]]
SHED = [[-8, 30], [20, 30], [20, 38], [-8, 38]]
YARD = [[0, 32], [10, 32], [10, 36], [0, 36]]


def as_kmz(data):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("doc.kml", data)
    return out.getvalue()


FORMS = {
    "geojson": (collection(geojson_trees(FIELD.orchard)), Form.GEOJSON, GROUND),
    "kml": (kml_trees(FIELD.orchard), Form.KML, GROUND),
    "kmz": (as_kmz(kml_trees(FIELD.orchard)), Form.KMZ, GROUND),
    "degrees": (csv_degrees(FIELD.orchard).encode("utf-8-sig"), Form.SHEET, GROUND),
    "metres": ((HEAD + csv_metres(FIELD.orchard)).encode(), Form.SHEET, Given(settings=SETTINGS)),
}


@cache
def drawn_as(form):
    data, *how = FORMS[form]
    return survey.parse(data, "f", *how)


@cache
def field_mission():
    return mission.plan(FIELD.orchard, FIELD.wishes, NOBODY)


def closed(site):
    positions = [degrees(FIELD.orchard, corner) for corner in site]
    return [*positions, positions[0]]


def line(row):
    return [degrees(FIELD.orchard, trunk) for trunk in FIELD.orchard.rows[row].trunks_site]


def read(features, given=HIGH, **members):
    return survey.parse(collection(features, **members), "f.geojson", Form.GEOJSON, given)


def refusal(data, form, given=HIGH):
    with pytest.raises(InputError) as caught:
        survey.parse(data, "f", form, given)
    return caught.value.faults


def polygon(*rings, **properties):
    return feature({"type": "Polygon", "coordinates": [closed(r) for r in rings]}, **properties)


def same_area(rings, wanted):
    found = shapely.union_all([shapely.Polygon(ring) for ring in rings])
    return found.symmetric_difference(wanted).area < 0.01


@pytest.mark.parametrize("form", FORMS)
def test_bare_trees_of_the_papers_orchard_give_the_same_waypoints(form):
    drawn = drawn_as(form)
    assert drawn.recognised.found is not None
    there, here = mission.plan(drawn.orchard, drawn.wishes, NOBODY), field_mission()
    assert there.waypoints_site == pytest.approx(here.waypoints_site, abs=0.01)
    assert there.waypoints_wgs84[:, :2] == pytest.approx(here.waypoints_wgs84[:, :2], abs=9e-8)
    for a, b in zip(drawn.orchard.rows, FIELD.orchard.rows, strict=True):
        assert a.trunks_site == pytest.approx(b.trunks_site, abs=0.001)
        assert a.heights.tolist() == b.heights.tolist()


@pytest.mark.parametrize("form", FORMS)
def test_converting_to_toml_keeps_every_bit(form):
    drawn = drawn_as(form)
    again = survey.parse(survey.text_of(drawn.tables, ("a remark",)).encode(), "f.toml")
    assert again.orchard.origin == drawn.orchard.origin
    assert again.orchard.name == drawn.orchard.name
    assert again.tables == drawn.tables
    for a, b in zip(again.orchard.rows, drawn.orchard.rows, strict=True):
        assert (a.trunks_site == b.trunks_site).all()
        assert (a.heights == b.heights).all()
        assert (a.ground == b.ground).all()


@pytest.mark.parametrize("name", ["lemon-field.survey.toml", "example.survey.csv"])
def test_converting_what_was_taped_keeps_every_bit(name):
    taped = survey.load(MISSIONS / name)
    again = survey.parse(survey.text_of(taped.tables).encode(), "f.toml")
    assert again.orchard.origin == taped.orchard.origin
    for a, b in zip(again.orchard.rows, taped.orchard.rows, strict=True):
        assert (a.trunks_site == b.trunks_site).all()
        assert (a.heights == b.heights).all()


def test_inner_boundaries_are_neither_lost_nor_swapped():
    """PEERS.md: inner boundaries lost on import, as tests counted and never compared geometry."""
    drawn = read(
        [
            polygon(OUTER, POND, name="Boundary"),
            polygon(SHED, YARD, name="no-fly zone"),
            *geojson_trees(FIELD.orchard),
        ]
    )
    assert same_area([drawn.orchard.fence_site], shapely.Polygon(OUTER))
    assert same_area(
        drawn.orchard.keep_outs_site,
        shapely.union(shapely.Polygon(POND), shapely.Polygon(SHED, [YARD])),
    )
    assert (
        not shapely.Polygon(YARD)
        .buffer(-0.1)
        .intersects(shapely.union_all([shapely.Polygon(r) for r in drawn.orchard.keep_outs_site]))
    )


def test_an_inner_boundary_drawn_as_a_boundary_of_its_own_is_a_keep_out():
    drawn = read(
        [polygon(OUTER, name="boundary"), polygon(POND, name="boundary 2"),
         *geojson_trees(FIELD.orchard)]
    )  # fmt: skip
    assert same_area([drawn.orchard.fence_site], shapely.Polygon(OUTER))
    assert same_area(drawn.orchard.keep_outs_site, shapely.Polygon(POND))


def test_multi_geometries_and_collections_keep_every_part():
    trees = [f["geometry"]["coordinates"] for f in geojson_trees(FIELD.orchard)]
    half = len(trees) // 2
    geometry = {
        "type": "GeometryCollection",
        "geometries": [
            {"type": "MultiPoint", "coordinates": trees[:half]},
            {"type": "GeometryCollection", "geometries": [
                {"type": "Point", "coordinates": tree} for tree in trees[half:]]},
        ],
    }  # fmt: skip
    areas = {"type": "MultiPolygon", "coordinates": [[closed(POND)], [closed(SHED), closed(YARD)]]}
    drawn = read([feature(geometry, height_m=1.8), feature(areas, kind="keep-out")])
    found = np.concatenate([row.trunks_site for row in drawn.orchard.rows])
    wanted = np.concatenate([row.trunks_site for row in FIELD.orchard.rows])
    assert found == pytest.approx(wanted, abs=0.001)
    assert same_area(
        drawn.orchard.keep_outs_site,
        shapely.union(shapely.Polygon(POND), shapely.Polygon(SHED, [YARD])),
    )


@pytest.mark.parametrize("order", ["lat,lon,height", "height,lon,lat", "LON,height,LAT"])
def test_columns_are_told_by_their_names_not_by_their_order(order):
    """PEERS.md: columns lost or swapped on import."""
    lines = [order]
    for tree in geojson_trees(FIELD.orchard):
        told = dict(zip(("lon", "lat"), tree["geometry"]["coordinates"], strict=True))
        told["height"] = tree["properties"]["height_m"]
        lines.append(",".join(repr(told[name]) for name in order.lower().split(",")))
    drawn = survey.parse("\n".join(lines).encode(), "f.csv", Form.SHEET, HIGH)
    for a, b in zip(drawn.orchard.rows, FIELD.orchard.rows, strict=True):
        assert a.trunks_site == pytest.approx(b.trunks_site, abs=0.001)
        assert a.heights.tolist() == b.heights.tolist()


def test_lines_are_rows_and_gather_the_trees_beside_them():
    rows = [feature({"type": "LineString", "coordinates": line(k)[::12]}) for k in range(5)]
    stray = point(degrees(FIELD.orchard, (20.0, 40.0)), height_m=2.5, name="stray")
    drawn = read([*rows, *geojson_trees(FIELD.orchard), stray])
    assert drawn.recognised.found is None
    for a, b in zip(drawn.orchard.rows, FIELD.orchard.rows, strict=True):
        assert a.trunks_site == pytest.approx(b.trunks_site, abs=0.001)
    (kept,) = drawn.orchard.obstacles
    assert kept.position_site == pytest.approx([20.0, 40.0], abs=0.001)
    assert kept.top == 2.5
    assert any("stray" in note for note in drawn.recognised.notes)


def test_bare_lines_are_planted_between_their_ends():
    lines = {"type": "MultiLineString", "coordinates": [line(k)[::12] for k in range(5)]}
    drawn = read([feature(lines, height_m=1.9)], Given(ground_height_m=40.0, tree_gap_m=4.0))
    for a, b in zip(drawn.orchard.rows, FIELD.orchard.rows, strict=True):
        assert a.trunks_site[[0, -1]] == pytest.approx(b.trunks_site[[0, -1]], abs=0.001)
        assert np.hypot(*np.diff(a.trunks_site, axis=0).T).max() <= 4.0


def test_obstacles_takeoff_and_landing_keep_their_places_and_names():
    drawn = read(
        [
            *geojson_trees(FIELD.orchard),
            point(degrees(FIELD.orchard, (19.0, 7.0)), name="Old mast", radius="0,15", height=8),
            point(degrees(FIELD.orchard, (-6.0, 1.0)), name="Take-off"),
            point(degrees(FIELD.orchard, (-6.0, 3.0)), name="landing"),
        ]
    )
    (mast,) = drawn.orchard.obstacles
    assert (mast.name, mast.radius, mast.top) == ("Old mast", 0.15, 8.0)
    assert mast.position_site == pytest.approx([19.0, 7.0], abs=0.001)
    assert drawn.wishes.takeoff_site == pytest.approx([-6.0, 1.0], abs=0.001)
    assert drawn.wishes.landing_site == pytest.approx([-6.0, 3.0], abs=0.001)


def test_ground_heights_come_with_the_positions():
    features = geojson_trees(FIELD.orchard)
    for k, tree in enumerate(features):
        tree["geometry"]["coordinates"].append(312.0 + 0.01 * k)
    drawn = read(features, Given())
    ground = np.concatenate([row.ground for row in drawn.orchard.rows])
    assert ground == pytest.approx(0.01 * np.arange(len(features)), abs=1e-6)
    assert drawn.orchard.origin.height == 312.0


def test_kml_of_another_library_in_nested_folders_is_read_the_same():
    ns = "{http://www.opengis.net/kml/2.2}"
    top = fastkml.KML(ns=ns)
    document = fastkml.Document(ns=ns, name="farm")
    trees, areas = (fastkml.Folder(ns=ns, name=name) for name in ("Trees", "Areas"))
    for tree in geojson_trees(FIELD.orchard):
        height = fastkml.Data(ns=ns, name="Height_m", value=str(tree["properties"]["height_m"]))
        trees.append(
            fastkml.Placemark(
                ns=ns, geometry=pygeoif.Point(*tree["geometry"]["coordinates"]),
                extended_data=fastkml.ExtendedData(ns=ns, elements=[height]),
            )
        )  # fmt: skip
    no_fly = fastkml.Folder(ns=ns, name="Keep out")
    for name, rings in (("Boundary", (OUTER, POND)), ("mill", (SHED, YARD))):
        outer, *inner = (closed(ring) for ring in rings)
        (areas if name == "Boundary" else no_fly).append(
            fastkml.Placemark(ns=ns, name=name, geometry=pygeoif.Polygon(outer, inner))
        )
    areas.append(no_fly)
    document.append(trees)
    document.append(areas)
    top.append(document)
    drawn = survey.parse(top.to_string().encode(), "f.kml", Form.KML, HIGH)
    for a, b in zip(drawn.orchard.rows, FIELD.orchard.rows, strict=True):
        assert a.trunks_site == pytest.approx(b.trunks_site, abs=0.001)
        assert a.heights.tolist() == b.heights.tolist()
    assert same_area([drawn.orchard.fence_site], shapely.Polygon(OUTER))
    assert same_area(
        drawn.orchard.keep_outs_site,
        shapely.union(shapely.Polygon(POND), shapely.Polygon(SHED, [YARD])),
    )


def test_the_first_tree_of_the_file_is_the_origin_where_it_can_be():
    turned = read(list(reversed(geojson_trees(FIELD.orchard))))
    assert math.degrees(turned.orchard.origin.heading) == pytest.approx(255.0, abs=1e-3)
    last = FIELD.orchard.rows[-1].trunks_site[-1]
    first = FIELD.orchard.rows[0].trunks_site[0]
    assert turned.orchard.rows[-1].trunks_site[-1] == pytest.approx(last - first, abs=0.001)


TREE = {"type": "Point", "coordinates": [113.1, 23.4]}


@pytest.mark.parametrize(
    ("features", "where", "what"),
    [
        ([feature({"type": "Point", "coordinates": [23.45, 113.1]})], "feature 1: position 1",
         "latitude 113.1"),
        ([feature(TREE), feature({"type": "Circle"})], "features[1].geometry", "Circle"),
        ([feature(TREE), feature(None, name="lost")], "feature 2 'lost'", "no geometry"),
        ([feature({"type": "Polygon", "coordinates": []})], "feature 1", "without a ring"),
        ([feature({"type": "LineString", "coordinates": [[1, 2]]})], "feature 1", "1 positions"),
        ([feature({"type": "Point", "coordinates": [1]})], "feature 1: position 1", "[1.0]"),
        ([feature(TREE), feature({"type": "Point", "coordinates": [113.1, 24.4]})], "feature 2",
         "more than 5 km"),
        ([polygon([[0, 0], [9, 9], [9, 0], [0, 9]])], "feature 1", "crosses itself"),
        ([*geojson_trees(FIELD.orchard), feature({"type": "LineString", "coordinates":
          line(0)[:2]}, name="power line")], "feature 66 'power line'", "not a row"),
        ([*geojson_trees(FIELD.orchard), polygon([[-1, -1], [20, -1], [20, 9], [-1, 9]])],
         "feature 66", "some of the trees"),
        ([*geojson_trees(FIELD.orchard), point(degrees(FIELD.orchard, (9, 7)), name="pole")],
         "feature 66 'pole'", "without radius_m"),
        ([*geojson_trees(FIELD.orchard), polygon(OUTER, name="fence"),
          polygon([[70, 0], [80, 0], [80, 9]], name="fence")], "feature 67 'fence'", "apart"),
        ([point(degrees(FIELD.orchard, (x, y)), row=1 if x else "", height=2)
          for x in (0, 3) for y in (0, 5)], "feature 1", "has no row"),
        ([point(degrees(FIELD.orchard, (3 * k, 0))) for k in range(9)], "f", "no height"),
    ],
)  # fmt: skip
def test_what_cannot_be_understood_is_refused_with_its_place(features, where, what):
    faults = refusal(collection(features), Form.GEOJSON)
    assert where in faults[0].where
    assert what in faults[0].what


@pytest.mark.parametrize(
    ("body", "where", "what"),
    [
        ("<Placemark><name>a</name></Placemark>", "placemark 1 'a'", "no geometry"),
        (kml_mark("<Point><coordinates>x,1</coordinates></Point>"), "placemark 1", "'x,1'"),
        (kml_mark("<Point><coordinates>1,nan</coordinates></Point>"), "placemark 1", "nan"),
        (kml_mark("<Model/>"), "placemark 1, line 1", "Model is not understood"),
        ("<NetworkLink/>", "f, line 1", "NetworkLink is not understood"),
        ("<GroundOverlay/>", "f, line 1", "GroundOverlay"),
        (kml_mark("<Polygon/>"), "placemark 1", "0 outer rings"),
    ],
)
def test_kml_that_cannot_be_understood_is_refused_with_its_place(body, where, what):
    faults = refusal(kml(body), Form.KML)
    assert where in faults[0].where
    assert what in faults[0].what


def test_what_the_files_lack_is_asked_for_not_guessed():
    faults = refusal(collection(geojson_trees(FIELD.orchard)), Form.GEOJSON, Given())
    assert "--ground-height" in faults[0].mend
    bare = [feature(tree["geometry"]) for tree in geojson_trees(FIELD.orchard)]
    faults = refusal(collection(bare), Form.GEOJSON)
    assert "--tree-height" in faults[0].mend


@pytest.mark.parametrize(
    ("data", "form"),
    [
        (b"[" * 1_000_000, Form.GEOJSON),
        (b'{"type":"GeometryCollection","geometries":[' * 50_000, Form.GEOJSON),
        (b'{"type":"FeatureCollection","features":[' + b"null," * 100_000, Form.GEOJSON),
        (b'{"type":"Point","coordinates":[NaN,1]}', Form.GEOJSON),
        (b'{"type":"Point","coordinates":[1e999,1]}', Form.GEOJSON),
        (b"\xff\xfe{\x00", Form.GEOJSON),
        (json.dumps({"type": "FeatureCollection", "features": [], "crs": {"properties": {
            "name": "EPSG:32650"}}}).encode(), Form.GEOJSON),
        (b"<a>" * 100_000, Form.KML),
        (b"\x00\xff\xfe", Form.KML),
        (b'<!DOCTYPE k [<!ENTITY a "b">]><kml>&a;</kml>', Form.KML),
        (b'<!DOCTYPE k SYSTEM "file:///etc/passwd"><kml/>', Form.KML),
        ('<!DOCTYPE k [<!ENTITY a "b">]><kml>&a;</kml>'.encode("utf-16"), Form.KML),
        (b"<html/>", Form.KML),
        (b"PK\x03\x04", Form.KMZ),
        (as_kmz(b" " * 30_000_000), Form.KMZ),
        (b"x_m,y_m,height\n0,nan,2\n", Form.SHEET),
        ((HEAD + "x_m,y_m,x_m\n0,1,2\n").encode(), Form.SHEET),
    ],
)  # fmt: skip
def test_hostile_files_are_refused_in_one_line_each(data, form):
    for fault in refusal(data, form):
        assert str(fault).isprintable()
        assert len(str(fault)) < 400


SCHEMA = json.loads(
    resources.files("orchard_cli.survey").joinpath("survey.schema.json").read_text("utf-8")
)


def test_the_schema_in_the_package_accepts_what_is_written_and_what_crews_wrote():
    check = Draft202012Validator(SCHEMA)
    Draft202012Validator.check_schema(SCHEMA)
    for data, form, given in FORMS.values():
        check.validate(survey.parse(data, "f", form, given).tables)
    for path in MISSIONS.glob("*.survey.*"):
        if path.name.endswith((".survey.toml", ".survey.csv")):
            check.validate(survey.load(path).tables)
    assert not check.is_valid({**FIELD.tables, "row": [{"gaps_m": [-1], "tree_height_m": 2}]})
