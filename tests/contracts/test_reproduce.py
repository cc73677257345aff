"""What scripts may rely on of `orchard reproduce`; nothing is flown here."""

import json
import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orchard_cli.analysis.paper import Published
from orchard_cli.commands.app import app
from orchard_cli.commands.reproduction import (
    flights,
    huang_flights,
    liu2024,
    registry,
    worlds,
    worlds_shown,
)
from orchard_cli.commands.reproduction.ahmed_fields import (
    COURSES,
    POLE,
    field_obstacles,
    limits,
    mission,
    world,
)
from orchard_cli.commands.reproduction.desk import Desk
from orchard_cli.commands.reproduction.flights import Outcome
from orchard_cli.commands.reproduction.rows import Row, difference, document
from orchard_cli.commands.wiring import Choices
from orchard_cli.errors import InputError
from orchard_cli.simulator.world_file import parse


def test_every_paper_has_tables_that_can_be_asked_for_by_number():
    for paper in registry.papers(registry.ALL):
        assert paper.title
        assert paper.tables
        for key in paper.tables:
            assert registry.chosen(paper, key) == {key: paper.tables[key]}


def test_unknown_papers_and_tables_say_which_there_are():
    with pytest.raises(InputError, match="ahmed2022"):
        registry.papers("ahmed2021")
    (paper,) = registry.papers("ahmed2022")
    with pytest.raises(InputError, match="fig13"):
        registry.chosen(paper, "17")
    assert list(registry.chosen(paper, "Table 4")) == ["4"]
    assert list(registry.chosen(paper, "Fig. 13")) == ["fig13"]


def test_rows_hold_no_number_that_json_has_not():
    row = Row("Table 1", "a", "b", 2.0, math.nan, "m")
    text = json.dumps(document([row]), allow_nan=False)
    assert json.loads(text)["rows"] == [
        {"table": "Table 1", "row": "a", "column": "b", "paper": 2.0, "ours": None, "unit": "m",
         "note": ""}
    ]  # fmt: skip
    assert difference(row) == ""
    assert difference(Row("t", "r", "c", 2.0, 3.0, "m")) == "+1 (+50 %)"


def test_several_flights_are_told_by_their_median_and_their_spread():
    flown = [Outcome(str(k), {"duration_s": value}) for k, value in enumerate((3.0, 1.0, 2.5))]
    flown.append(Outcome("3", {"duration_s": "the last waypoint was not reached"}))
    paper = Published("paper", "source", {"duration_s": 2.0})
    row = liu2024._rows("Table 1", "guided", paper, flown)[0]
    assert (row.ours, row.low, row.high) == (2.5, 1.0, 3.0)
    (entry, *_) = document([row])["rows"]
    assert sorted(entry) == ["column", "note", "ours", "paper", "row", "table", "unit"]
    assert "median of 3 flights, 1 to 3" in entry["note"]
    assert "3: the last waypoint was not reached" in entry["note"]


def test_what_was_flown_with_the_same_inputs_is_not_flown_again(monkeypatch, tmp_path):
    flown = []

    def fly_mission(mission, choices, log, *args, **kwargs):
        flown.append(log.name)
        log.write_bytes(b"a log")
        if choices.seed == 7:
            raise RuntimeError("a bug")

    monkeypatch.setattr("orchard_cli.commands.fly.fly_mission", fly_mission)
    monkeypatch.setattr(flights, "_measure", lambda task: {"duration_s": 1.0, "b": "not there"})

    def outcome(seed=1, world="a", reuse=False):
        mission = Path(liu2024.__file__).parents[3] / "missions/lemon-field.mission.json"
        task = flights.Task(
            tmp_path, f"one-{seed}", mission.read_text(), world, Choices(seed=seed), reuse
        )
        return flights.fly_and_measure(task)

    first = outcome()
    assert outcome() == first == Outcome("one-1", {"duration_s": 1.0, "b": "not there"})
    assert flown == ["one-1.mcap"]
    outcome(world="b")
    assert flown == ["one-1.mcap"] * 2  # another world
    outcome(world="c", reuse=True)
    assert len(flown) == 2
    broken = outcome(seed=7)
    assert broken.why_not("duration_s") == "RuntimeError: a bug"
    outcome(seed=7)
    assert flown[2:] == ["one-7.mcap"] * 2  # it was not flown to its end


def test_json_is_the_only_thing_on_stdout_and_out_keeps_it(monkeypatch, tmp_path):
    def table(desk: Desk) -> list[Row]:
        desk.say("measuring")
        return [Row("Table 9", "a", "b", 1.0, 1.5, "m")]

    paper = registry.Paper("ahmed2022", "a title", {"9": table})
    monkeypatch.setattr(registry, "_paper", lambda name: paper)
    out = tmp_path / "made"
    done = CliRunner().invoke(app, ["reproduce", "ahmed2022", "--json", "--out", str(out)])
    assert done.exit_code == 0
    assert json.loads(done.stdout)["rows"][0]["ours"] == 1.5
    assert json.loads((out / "rows.json").read_text()) == json.loads(done.stdout)
    shown = CliRunner().invoke(app, ["reproduce", "ahmed2022", "-q"])
    assert "+0.5 (+50 %)" in shown.stdout


@pytest.mark.parametrize("course", COURSES)
def test_the_fields_have_the_lengths_and_areas_of_the_paper(course):
    ys = [k * course.gap for k in range(int(12 / course.gap) + 1)]
    planned = mission(ys, course.speed, 0.5, course.gap)
    assert planned.route_length + 3.0 == pytest.approx(course.length)  # the climb counts there
    assert (40 + course.gap) * (12 + course.gap) == pytest.approx(course.area)
    made = parse(world(field_obstacles(), planned, 0), "made")
    assert (len(made.poles), len(made.boxes)) == (2 + 2, 2)


def test_a_full_tank_flies_with_less():
    assert limits(3.5, 1.0).acceleration < limits(3.5, 0.1).acceleration == 3.0
    assert len(parse(world(POLE, mission([0.0], 3.5, 1.0, 3.0), 0), "made").poles) == 3


def test_the_grand_table_has_each_system_in_each_world(monkeypatch, tmp_path):
    """Nothing is flown: what the flights would have found is put in."""
    asked = []

    def fly_all(desk, tasks):
        asked.extend(tasks)
        return [
            Outcome(task.name, {"contacts": 1.0, "clearance_min_m": 0.5, "duration_s": "no"})
            if task.choices.system == "none" else Outcome(task.name, failed="no such sensor")
            for task in tasks
        ]  # fmt: skip

    monkeypatch.setattr(Desk, "fly_all", fly_all)
    monkeypatch.setattr(worlds_shown, "measured_flights", lambda flown: iter(()))
    rows = worlds.grand(Desk(tmp_path, quiet=True))
    names = {world.name.removesuffix(".world.toml") for world in worlds.worlds()}
    assert {(row.table, row.row) for row in rows} == {(w, s) for w in names for s in worlds.SYSTEMS}
    assert len(rows) == len(names) * len(worlds.SYSTEMS) * len(worlds.METRICS)
    assert len({task.log for task in asked}) == len(asked)
    blind = next(row for row in rows if row.row == "none")
    assert blind.ours == 1.0
    assert "senses by nothing; touched something; not whole" in blind.note
    told = next(row for row in rows if row.row == "dfa")
    assert "depth, radar, range" in told.note
    assert "no such sensor" in told.note
    shown = (tmp_path / "worlds.md").read_text()
    assert shown.count("| dfa | depth, radar, range |") == len(names)
    assert (tmp_path / "worlds.png").stat().st_size > 1000


def test_the_flights_of_huang_meet_their_obstacles():
    for case in huang_flights.CASES:
        made = parse(huang_flights._world(case, 0), case.name)
        flown = huang_flights._mission(case)
        assert flown.limits.speed == flown.waypoints_site[0, 2] == case.pace
        assert len(made.trees) + len(made.poles) == (4 if case.scene == "both" else 3)
