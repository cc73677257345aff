"""`orchard replay`: a log on the screen again, and thought over again."""

from __future__ import annotations

import json

import made_flights as made
import numpy as np
import pytest
from typer.testing import CliRunner

from orchard_cli.commands.app import app
from orchard_cli.commands.replaying.statuses import statuses
from orchard_cli.flightlog import McapRecorder, Rates, read
from orchard_cli.mission import dumps
from orchard_cli.model.records import PlannerRecord, SafetyRecord

from .test_analyze import write_log


def replay(*words):
    return CliRunner().invoke(app, ["replay", *map(str, words)])


def seen(records):
    """Every image with a cycle of its own that kept the path; the route begins at once."""
    for one in records:
        if isinstance(one, PlannerRecord | SafetyRecord):
            continue
        yield one
        if type(one).__name__ == "RunHeader":
            yield SafetyRecord(100.0, "route", "fly", "on the route")
        if type(one).__name__ == "DepthFrame":
            yield PlannerRecord(one.time, one.time, "keep", "free", None, {"cycle": 5.0})


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """The route as planned, in front of a wall 2 m ahead in every image."""
    path = tmp_path_factory.mktemp("replay") / "wall.mcap"
    plan = made.planned_mission()
    recorder = McapRecorder(path, rates=Rates(depth=15.0), patient=True)
    files = {"mission.json": dumps(plan).encode()}
    flight = made.flight(plan, depth=True, attachments=files, as_planned=True)
    for number, one in enumerate(seen(flight)):
        if number > 2500:
            break
        recorder.write(one)
    recorder.close()
    return path


def test_decisions_that_differ_today_are_told_with_both_reasons(log):
    """The made-up planner flew on towards a wall: the real one does not."""
    result = replay(log, "--rethink", "--json")
    assert result.exit_code == 0, result.exception
    found = json.loads(result.stdout)
    assert found["frames"] > 10
    assert found["replayed"] + found["skipped"] == found["frames"]
    assert found["same"] + len(found["differing"]) == found["replayed"]
    assert any(one["again"] in ("stop", "avoid") for one in found["differing"])
    assert all(one["logged"] == "keep" and one["again_why"] for one in found["differing"])


def test_a_system_without_eyes_decides_as_the_made_up_one(log):
    said = replay(log, "--rethink", "--system", "none").stdout
    assert "decided the same" in said
    assert "logged keep" not in said


def test_the_screen_shows_the_flight_from_its_first_to_its_last_moment(log):
    flown = read(log)
    shown = list(statuses(flown, made.planned_mission()))
    times = flown.odometry.times
    assert len(shown) == int(np.ceil((times[-1] - times[0]) / 0.25))
    assert shown[0].time == 0.0
    progress = [one.progress for one in shown]
    assert progress == sorted(progress)
    assert {one.phase.value for one in shown} >= {"route"}
    off = [one.cross_track for one in shown]
    assert min(off) < 0.1
    assert max(off) < 4.1  # it takes off 4 m before the first row


def test_playing_shows_the_last_picture(log):
    result = replay(log, "--speed-factor", "1000")
    assert result.exit_code == 0, result.exception


def test_options_of_thinking_again_belong_to_it(log, tmp_path):
    assert "belongs to --rethink" in str(replay(log, "--json").exception)
    blind = write_log(tmp_path / "blind.mcap")
    assert "holds no depth images" in str(replay(blind, "--rethink").exception)
