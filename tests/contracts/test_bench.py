"""`orchard bench`, as a shell sees it: the shape of its document, never how fast anything is."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from orchard_cli.commands.benchmarks.document import load, ratios

STAGES = {
    "render", "project", "map_update", "map_update_ego", "distance_field", "check", "search",
    "optimise", "replan", "cycle", "log_thread", "lockstep",
}  # fmt: skip
FIGURES = {"n", "median_ms", "p95_ms", "p99_ms", "max_ms"}


def orchard_bench(*arguments):
    return subprocess.run(
        [sys.executable, "-c", "from orchard_cli.commands import main; main()", "bench",
         *arguments],
        capture_output=True, text=True, timeout=280, check=False,
    )  # fmt: skip


@pytest.fixture(scope="module")
def done():
    return orchard_bench("--quick", "--json", "--system", "guided")


@pytest.fixture(scope="module")
def document(done):
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout)


def test_every_stage_has_its_figures_in_order(document):
    assert set(document["stages"]) >= STAGES
    for name, found in document["stages"].items():
        assert set(found) == FIGURES, name
        assert found["n"] > 0
        ordered = [found[f] for f in ("median_ms", "p95_ms", "p99_ms", "max_ms")]
        assert ordered == sorted(ordered), name


def test_the_machine_and_its_load_stand_beside_the_figures(document):
    assert document["schema"] == "orchard-bench/1"
    assert set(document["machine"]) >= {"processor", "cores", "load_1min", "python", "numba"}


def test_replans_tell_success_time_and_clearance_in_every_field(document):
    fields = document["replanning"]["guided"]
    assert set(fields) == {
        "density_0.02", "density_0.05", "forced", "forced_0.02", "forced_0.05",
    }  # fmt: skip
    for found in fields.values():
        assert found["n"] == 10
        assert 0 <= found["searched_share"] <= 1
        assert 0 <= found["first_call_share"] <= 1
        assert set(found["replan"]) == set(found["plan"]) == FIGURES
    assert fields["forced"]["searched_share"] == 1


def test_a_comparison_tells_new_over_old(document, tmp_path):
    old, new = tmp_path / "old.json", json.loads(json.dumps(document))
    old.write_text(json.dumps(document))
    new["stages"]["check"]["median_ms"] *= 2
    del new["stages"]["render"]
    found = ratios(new, load(old))
    assert set(found) >= STAGES - {"render"} | {"guided/forced"}
    assert found["check"]["median_ms"] == pytest.approx(2.0, abs=1e-3)
    assert found["cycle"] == {"median_ms": 1.0, "p95_ms": 1.0, "p99_ms": 1.0, "max_ms": 1.0}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--system", "magic"], "no planning system 'magic'"),
        (["--system", "none"], "no planning system 'none'"),
        (["--compare", "missing.json"], "missing.json"),
        (["--compare", __file__], "no document of a bench"),
    ],
)
def test_wrong_input_is_one_line_and_exit_code_2(arguments, said):
    done = orchard_bench("--quick", *arguments)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
