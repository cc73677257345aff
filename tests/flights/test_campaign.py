"""`orchard campaign orchards`, as a user runs it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from orchard_cli.flightlog import read

pytestmark = pytest.mark.flight
ORCHARD = Path(sys.executable).parent / "orchard"


def test_the_same_figures_for_any_number_of_workers_and_a_case_can_be_flown_again(tmp_path):
    told = []
    for workers in ("1", "2"):
        words = ("campaign", "orchards", "--n", "2", "--seed", "4", "--system", "none", "--json",
                 "--workers", workers, "--out", tmp_path / workers)  # fmt: skip
        told.append(subprocess.run([ORCHARD, *words], capture_output=True, check=True).stdout)
    assert told[0] == told[1]
    words = ("campaign", "orchards", "--seed", "4", "--system", "none", "--json", "--only", "1",
             "--out", tmp_path / "again")  # fmt: skip
    again = json.loads(subprocess.run([ORCHARD, *words], capture_output=True, check=True).stdout)
    lines = [
        json.loads(line) for line in (tmp_path / "1" / "cases.ndjson").read_text().splitlines()
    ]
    assert {**again, "kept": None} == {**lines[2], "kept": None}
    assert read(tmp_path / "again" / "kept" / "case-4-1.mcap").truth is not None
