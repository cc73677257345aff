"""No bytes make a reader of surveys fail in another way than by faults of one line each.

`ORCHARD_FUZZ=10000 pytest tests/laws/test_survey_fuzz.py` runs that many cases a reader.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from made_surveys import collection, feature, kml, kml_mark, point

from orchard_cli import survey
from orchard_cli.errors import InputError
from orchard_cli.survey import Form, Given
from orchard_cli.survey.kml import unpacked

CASES = int(os.environ.get("ORCHARD_FUZZ", "25"))
often = settings(
    max_examples=CASES, deadline=None, derandomize=True,
    suppress_health_check=list(HealthCheck), database=None,
)  # fmt: skip
GIVEN = Given(tree_height_m=2.0, ground_height_m=10.0)
TREES = [point([113.1 + 3e-5 * (k % 4), 23.4 + 6e-5 * (k // 4)], height=2.5) for k in range(12)]
SQUARE = [[113.09, 23.39], [113.11, 23.39], [113.11, 23.41], [113.09, 23.41], [113.09, 23.39]]
GEOJSON = collection(
    [*TREES, feature({"type": "Polygon", "coordinates": [SQUARE]}, name="fence")]
).decode()
KML = kml(
    "".join(
        kml_mark(f"<Point><coordinates>{x},{y}</coordinates></Point>", height=2)
        for x, y in (t["geometry"]["coordinates"] for t in TREES)
    )
    + kml_mark(
        "<Polygon><outerBoundaryIs><LinearRing><coordinates>113.09,23.39 113.12,23.39 113.12,23.42 "
        "113.09,23.39</coordinates></LinearRing></outerBoundaryIs></Polygon>", "fence",
    )
).decode()  # fmt: skip
SHEET = "lat;lon;height;row\n" + "".join(
    f"{t['geometry']['coordinates'][1]};{t['geometry']['coordinates'][0]};2,5;{k // 4}\n"
    for k, t in enumerate(TREES)
)
TEXTS = {Form.GEOJSON: GEOJSON, Form.KML: KML, Form.SHEET: SHEET}
PIECES = [
    "", "-", "nan", "1e999", "[", "]", "{", "}", '"', "<", ">", "&a;", "\n", ";", ",", "9" * 40,
    "null", "true", "</Point>", "<Folder>", "]]>", "\x00", "\ufeff", "Polygon", "LineString",
    '"row"', "180", "90", "0", "é",
]  # fmt: skip


def read(data, form):
    faults = ()
    try:
        survey.parse(data, "f", form, GIVEN)
    except InputError as error:
        faults = error.faults
    for fault in faults:
        assert str(fault).isprintable(), str(fault)


@pytest.mark.parametrize("form", list(TEXTS))
def test_the_unspoilt_texts_are_surveys(form):
    survey.parse(TEXTS[form].encode(), "f", form, GIVEN)


@pytest.mark.parametrize("form", list(TEXTS))
def test_no_mutilated_drawing_makes_it_fail_in_another_way(form):
    text = TEXTS[form]

    @given(
        st.lists(
            st.tuples(
                st.integers(0, len(text)), st.integers(0, 30), st.sampled_from(PIECES)
            ),
            min_size=1, max_size=4,
        )
    )  # fmt: skip
    @often
    def holds(edits):
        spoilt = text
        for at, cut, put in edits:
            spoilt = spoilt[:at] + put + spoilt[at + cut :]
        read(spoilt.encode(), form)

    holds()


@pytest.mark.parametrize("form", list(Form))
def test_no_bytes_make_it_fail_in_another_way(form):
    @given(st.binary(max_size=300))
    @often
    def holds(data):
        if form is Form.TOML:
            with pytest.raises(InputError):
                survey.parse(data, "f", form)
        else:
            read(data, form)

    holds()


position = st.lists(st.floats(-200, 200, allow_nan=False) | st.sampled_from([113.1, 23.4]),
                    min_size=1, max_size=4)  # fmt: skip
near = st.tuples(st.floats(113.1, 113.101), st.floats(23.4, 23.401)).map(list)
places = st.lists(near, max_size=8)
geometry = st.recursive(
    st.one_of(
        st.builds(lambda c: {"type": "Point", "coordinates": c}, near | position),
        st.builds(lambda c: {"type": "MultiPoint", "coordinates": c}, places),
        st.builds(lambda c: {"type": "LineString", "coordinates": c}, places),
        st.builds(lambda c: {"type": "Polygon", "coordinates": [c + c[:1]]}, places),
        st.builds(lambda c: {"type": "MultiLineString", "coordinates": c}, st.lists(places)),
    ),
    lambda inner: st.builds(
        lambda g: {"type": "GeometryCollection", "geometries": g}, st.lists(inner, max_size=4)
    ),
    max_leaves=6,
)
told = st.dictionaries(
    st.sampled_from(["name", "kind", "row", "height", "radius", "layer"]),
    st.sampled_from(["tree", "row", "fence", "keep-out", "pole", "1", 2, 2.5, None, True, [1], ""]),
)


@given(st.lists(st.tuples(geometry, told), max_size=8))
@often
def test_no_drawing_makes_it_fail_in_another_way(drawn):
    members = [feature(shape, **properties) for shape, properties in drawn]
    read(json.dumps({"type": "FeatureCollection", "features": members}).encode(), Form.GEOJSON)


@given(st.binary(max_size=200))
@often
def test_no_archive_makes_it_fail_in_another_way(data):
    with suppress(InputError):
        unpacked(b"PK\x03\x04" + data, "f")
