"""Exports and folders: what other programs read, and the same for one worker or several."""

from __future__ import annotations

import csv
import json
import shutil

import numpy as np
import pytest
import shapely
from typer.testing import CliRunner

from orchard_cli.commands.app import app
from orchard_cli.errors import InputError
from orchard_cli.flightlog import read
from orchard_cli.geometry.geodesy import site_from_wgs84
from orchard_cli.mission import loads

from .test_analyze import write_log


def analyze(*words):
    return CliRunner().invoke(app, ["analyze", *map(str, words)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two flights and a file that is none, one of them in a folder below."""
    path = tmp_path_factory.mktemp("logs")
    write_log(path / "a.mcap")
    (path / "day 2").mkdir()
    shutil.copy(path / "a.mcap", path / "day 2" / "[red]b.mcap")
    (path / "junk.mcap").write_bytes(b"no log")
    return path


def test_csv_gives_every_metric_back_to_the_last_bit(folder, tmp_path):
    out = tmp_path / "metrics.csv"
    told = json.loads(analyze(folder / "a.mcap", "--json", "--csv", out).stdout)["logs"][0]
    (row,) = list(csv.DictReader(out.read_text().splitlines()))
    assert row["file"] == "a.mcap"
    for name, figure in told["metrics"].items():
        assert (float(row[name]) if row[name] else None) == figure


def test_geojson_is_the_as_applied_map_in_wgs84(folder, tmp_path):
    """Back in the site frame its areas are those that the coverage is made of."""
    out = tmp_path / "applied.geojson"
    told = json.loads(analyze(folder / "a.mcap", "--json", "--geojson", out).stdout)["logs"][0]
    features = {f["properties"]["kind"]: f for f in json.loads(out.read_text())["features"]}
    assert {"applied", "missed", "flown"} <= set(features)
    mission = loads(read(folder / "a.mcap").attachments["mission.json"], "mission")

    def in_site(lonlat):
        level = np.full(len(lonlat), mission.orchard.origin.height)
        places = np.column_stack([lonlat[:, [1, 0]], level])
        return site_from_wgs84(mission.orchard.origin, places)[:, :2]

    shapes = {
        kind: shapely.transform(shapely.from_geojson(json.dumps(f["geometry"])), in_site)
        for kind, f in features.items()
    }
    for kind in ("applied", "missed"):
        told_area = features[kind]["properties"]["area_m2"]
        assert shapes[kind].area == pytest.approx(told_area, rel=1e-3)
    planned = shapes["missed"].area + shapes["applied"].area
    covered = 100 * shapes["applied"].area / planned  # nearly nothing is sprayed beside the plan
    assert covered == pytest.approx(told["metrics"]["coverage_percent"], abs=2.0)
    path = read(folder / "a.mcap").odometry.positions_site[:, :2]
    assert shapes["flown"].hausdorff_distance(shapely.LineString(path)) < 0.05
    for ring in features["applied"]["geometry"]["coordinates"]:
        assert shapely.LinearRing(ring[0]).is_ccw  # RFC 7946, 3.1.6


def test_tum_has_one_pose_a_line_with_the_scalar_last(folder, tmp_path):
    out = tmp_path / "path.tum"
    assert analyze(folder / "a.mcap", "--json", "--tum", out).exit_code == 0
    table = np.loadtxt(out)
    track = read(folder / "a.mcap").odometry
    np.testing.assert_allclose(table[:, 0], track.times, atol=1e-6)
    np.testing.assert_allclose(table[:, 1:4], track.positions_site, atol=1e-6)
    np.testing.assert_allclose(table[:, [7, 4, 5, 6]], track.site_from_body, atol=1e-8)


def test_a_folder_gives_the_same_lines_for_one_worker_and_for_two(folder):
    one, two = (analyze(folder, "--ndjson", "--workers", n) for n in (1, 2))
    assert one.stdout == two.stdout
    entries = [json.loads(line) for line in one.stdout.splitlines()]
    assert [entry["file"] for entry in entries] == ["a.mcap", "day 2/[red]b.mcap", "junk.mcap"]
    assert entries[0]["metrics"] == entries[1]["metrics"]
    assert "is no MCAP log" in entries[2]["error"][0]
    assert isinstance(two.exception, InputError)  # after everything that could be measured
    assert len(two.exception.faults) == 1


def test_a_folder_on_a_dask_cluster_gives_the_same_lines(folder):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        found = analyze(folder, "--ndjson", "--dask", cluster.scheduler_address)
    assert found.stdout == analyze(folder, "--ndjson").stdout


def test_a_folder_as_a_table_shows_names_as_they_are(folder):
    said = analyze(folder).stdout
    assert "[red]b.mcap" in said
    assert "not measured" in said


def test_csv_of_a_folder_keeps_why_a_log_was_not_measured(folder, tmp_path):
    out = tmp_path / "all.csv"
    analyze(folder, "--ndjson", "--csv", out)
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert [bool(row["error"]) for row in rows] == [False, False, True]


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--html", "x.html"], "--html: is for a few logs"),
        (["--compare"], "--compare: is for a few logs"),
        (["--tum", "x.tum"], "--tum: is for one log"),
        (["--json", "--ndjson"], "another form than --json"),
    ],
)
def test_what_a_folder_cannot_give_is_told_before_anything_is_measured(folder, words, complaint):
    result = analyze(folder, *words)
    assert complaint in str(result.exception)
    assert result.stdout == ""


def test_an_empty_folder_is_told(tmp_path):
    assert "holds no log" in str(analyze(tmp_path).exception)
