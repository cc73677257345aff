"""`orchard bench`: the shape of its document and its refusals, never how fast anything is."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from orchard_cli.commands.bench import bench
from orchard_cli.commands.benchmarks.document import SCHEMA, load, ratios
from orchard_cli.errors import InputError

STAGES = {
    "render", "project", "map_update", "map_update_low", "map_update_ego", "distance_field",
    "check", "search", "optimise", "replan", "cycle", "log_thread", "lockstep",
}  # fmt: skip
FIELDS = {"density_0.02", "density_0.05", "forced", "forced_0.02", "forced_0.05"}
MILLISECONDS = ("median_ms", "p95_ms", "p99_ms", "max_ms")


def test_quick_json_is_one_document_of_the_promised_shape():
    main = "from orchard_cli.commands import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", main, "bench", "--quick", "--json", "--system", "guided"],
        capture_output=True, text=True, timeout=280, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    document = json.loads(done.stdout)
    assert document["schema"] == "orchard-bench/1"
    assert set(document["machine"]) >= {"processor", "cores", "load_1min", "python", "numba"}
    assert set(document["stages"]) >= STAGES
    for name, found in document["stages"].items():
        demand_spread(found, name)
    demand_spread(document["setpoint_jitter"], "setpoint_jitter")
    assert set(document["replanning"]) == {"guided"}
    assert set(document["replanning"]["guided"]) == FIELDS
    for name, found in document["replanning"]["guided"].items():
        assert found["n"] == found["plan"]["n"] == 10
        demand_spread(found["plan"], name)
        assert (found["replan"] is None) == (found["replanned_share"] == 0)
    forced = document["replanning"]["guided"]["forced"]
    assert forced["replanned_share"] == 1
    assert 0 <= forced["first_call_share"] <= 1
    demand_spread(forced["replan"], "forced")
    assert document["lockstep"]["simulated_s"] == 4


def demand_spread(found, name):
    assert set(found) == {"n", *MILLISECONDS}, name
    assert found["n"] > 0, name
    assert 0 <= found["median_ms"] <= found["p95_ms"] <= found["p99_ms"] <= found["max_ms"], name


def spread(value):
    return {"n": 3, **dict.fromkeys(MILLISECONDS, value)}


def test_a_comparison_tells_new_over_old_of_what_both_have(tmp_path):
    old = {
        "schema": SCHEMA,
        "stages": {"check": spread(0.2), "cycle": spread(3.0), "gone": spread(1.0)},
        "replanning": {"guided": {"forced": {"replan": spread(2.0)}}},
    }
    new = {
        "stages": {"check": spread(0.1), "cycle": spread(3.0), "fresh": spread(1.0)},
        "replanning": {"guided": {"forced": {"replan": spread(3.0)}}},
    }
    path = tmp_path / "old.json"
    path.write_text(json.dumps(old))
    found = ratios(new, load(path))
    assert set(found) == {"check", "cycle", "guided/forced"}
    assert found["check"] == dict.fromkeys(MILLISECONDS, 0.5)
    assert found["cycle"] == dict.fromkeys(MILLISECONDS, 1.0)
    assert found["guided/forced"] == dict.fromkeys(MILLISECONDS, 1.5)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"system": ["magic"]}, "no planning system 'magic'"),
        ({"system": ["none"]}, "no planning system 'none'"),
        ({"compare": Path("missing.json")}, "missing.json"),
        ({"compare": Path(__file__)}, "no document of a bench"),
        ({"frames": Path("missing.mcap")}, "missing.mcap"),
    ],
)
def test_wrong_input_is_refused_before_anything_is_measured(arguments, said):
    with pytest.raises(InputError, match=said):
        bench(**{"quick": True, **arguments})


def test_octomap_that_is_not_installed_is_named_with_its_mend(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyoctomap", None)
    with pytest.raises(InputError, match="pip install pyoctomap"):
        bench(octomap=True, quick=True)
