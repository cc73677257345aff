"""`orchard check`, as a shell sees it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

MISSIONS = Path(__file__).parents[2] / "missions"
FIELD = MISSIONS / "lemon-field.mission.json"


def orchard(*arguments):
    return subprocess.run(
        [sys.executable, "-c", "from orchard_cli.commands import main; main()", *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_a_good_mission_is_told_rule_by_rule():
    done = orchard("check", str(FIELD), "--json")
    assert (done.returncode, done.stderr) == (0, "")
    told = json.loads(done.stdout)
    assert told["ok"]
    assert told["broken"] == 0
    assert told["checked"] == len(told["findings"]) > 20
    placed = [f for f in told["findings"] if "at_m" in f]
    assert all(len(f["at_m"]) == len(f["at_wgs84"]) == 3 for f in placed)
    assert all(f["limit"] is not None and f["sense"] in ("at least", "at most") for f in placed)


def test_a_pole_of_the_world_on_the_route_ends_with_2_and_its_place():
    done = orchard(
        "check", str(FIELD), "--world", str(MISSIONS / "lemon-field.world.toml"), "--json"
    )
    assert done.returncode == 2
    broken = [f for f in json.loads(done.stdout)["findings"] if not f["ok"]]
    assert [f["at_m"][:2] for f in broken] == [
        pytest.approx(place, abs=0.3) for place in ([14.5, 4.8], [24.0, 9.6], [20.0, 19.2])
    ]
    (line,) = done.stderr.splitlines()
    assert "breaks 3 of" in line


def test_a_mission_that_fly_refuses_is_explained(tmp_path):
    told = json.loads(FIELD.read_text(encoding="utf-8"))
    told["limits"]["speed_m_s"] = 0.8
    path = tmp_path / "fast.mission.json"
    path.write_text(json.dumps(told), encoding="utf-8")
    done = orchard("check", str(path))
    assert done.returncode == 2
    assert "BROKEN" in done.stdout
    assert "speed" in done.stdout
    assert "at most 0.8" in done.stdout


def test_what_is_no_mission_is_one_line():
    done = orchard("check", str(MISSIONS / "lemon-field.survey.toml"))
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
