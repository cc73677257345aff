"""Why it turned there: the decision, its image's age and its map are those of the log."""

from __future__ import annotations

from dataclasses import replace

import made_flights as made
import numpy as np
import pytest

from orchard_cli.analysis import Flight, Unknown, measure
from orchard_cli.analysis.page.words import story
from orchard_cli.analysis.turns import turns
from orchard_cli.analysis.verdicts import verdicts
from orchard_cli.flightlog import McapRecorder, read
from orchard_cli.model.records import NewTrajectory, OccupiedCells, PlannerRecord

DECIDED = 106.0  # s: the bump begins at 107


@pytest.fixture(scope="module")
def explained(tmp_path_factory):
    plan = made.mission(2)
    path = tmp_path_factory.mktemp("turns") / "one.mcap"
    recorder = McapRecorder(path, patient=True)
    for one in made.flight(plan, made.Bump(10.0, 6.0, 1.5)):
        recorder.write(one)
        if getattr(one, "time", 0.0) >= DECIDED and not isinstance(one, NewTrajectory):
            break
    new = NewTrajectory(DECIDED, plan.trajectory.shifted(100.0), np.empty((0, 3)), "blocked")
    recorder.write(
        PlannerRecord(DECIDED, DECIDED - 0.04, "avoid", "blocked in 4.0 m", 4.0, {"cycle": 9.0})
    )
    recorder.write(new)
    recorder.write(
        OccupiedCells(DECIDED + 0.3, np.array([[10.0, 0.0, 3.5], [10.0, 0.0, 0.1]]), 0.1)
    )
    for one in made.flight(plan, made.Bump(10.0, 6.0, 1.5)):
        if getattr(one, "time", 0.0) > DECIDED:
            recorder.write(one)
    recorder.close()
    log = replace(read(path), maps=read(path, topics=["/map/occupied"]).maps)
    far = Unknown("not measured")
    metrics = measure(log, plan, far)
    return Flight(log, plan, None, far, metrics, verdicts(metrics, plan))


def test_the_decision_is_told_with_the_age_of_its_image(explained):
    (turn,) = turns(explained)
    (choice,) = turn.choices
    assert choice.why == "blocked in 4.0 m"
    assert choice.frame_age == pytest.approx(0.04)
    assert turn.decided == DECIDED
    assert turn.vehicle_site[0] == pytest.approx(DECIDED - 100.0, abs=0.05)


def test_the_map_is_the_first_after_the_decision_at_flight_height(explained):
    (turn,) = turns(explained)
    assert turn.map_delay == pytest.approx(0.3)
    np.testing.assert_allclose(turn.cells_site, [[10.0, 0.0]], atol=1e-6)  # not the one below


def test_before_in_it_and_after_are_told_apart(explained):
    (turn,) = turns(explained)
    before, within, after = turn.bearings
    assert within.deviation_max_m == pytest.approx(1.5, abs=0.05)
    assert before.deviation_max_m < 0.1 > after.deviation_max_m - 0.3
    assert before.speed_m_s == pytest.approx(1.0, abs=0.1)


def test_the_story_names_reason_age_and_what_is_not_known(explained):
    (turn,) = turns(explained)
    told = " ".join(story(turn, 100.0))
    for words in ("At 6.0 s", "4.0 m ahead", "blocked in 4.0 m", "40 ms old", "9.0 ms", "1.50 m"):
        assert words in told, words
    assert "not known: not measured" in told


def test_a_detour_that_no_decision_explains_is_not_blamed_on_the_planner(explained):
    silent = replace(explained, log=replace(explained.log, planner=()))
    (turn,) = turns(silent)
    assert turn.choices == ()
    assert any("no decision" in sentence for sentence in story(turn, 100.0))
