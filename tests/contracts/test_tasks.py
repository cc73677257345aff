"""A file of tasks becomes a mission of straight legs and hovers (Wang 2020, §3.7)."""

import numpy as np
import pytest

from orchard_cli import mission as missions
from orchard_cli.errors import InputError
from orchard_cli.model.mission import Leg, Provenance
from orchard_cli.model.tasks import FlyTo, Hover, Land, TakeOff
from orchard_cli.survey import load_tasks, parse

TASKS = """
[[task]]
do = "takeoff"
at_m = [-4.0, 0.0]
height_m = 3.0
[[task]]
do = "fly"
to_m = [12.0, 0.0]
[[task]]
do = "hover"
for_s = 4
[[task]]
do = "fly"
to_m = [12.0, 8.0]
height_m = 4.0
[[task]]
do = "land"
"""
AGAIN = '"takeoff"\nat_m = [0, 0]\nheight_m = 3'
SURVEY = b"""
[site]
latitude_deg = 23.45
longitude_deg = 113.13
height_m = 40.0
heading_deg = 75.0
[flight]
height_m = 3.0
[[row]]
gaps_m = [6.0, 6.0]
tree_height_m = 1.0
"""


def tasks_of(tmp_path, text):
    path = tmp_path / "yard.tasks.toml"
    path.write_text(text)
    return load_tasks(path)


@pytest.fixture(scope="module")
def mission():
    surveyed = parse(SURVEY, "yard.survey.toml")
    tasks = (
        TakeOff(np.array([-4.0, 0.0]), 3.0), FlyTo(np.array([12.0, 0.0])), Hover(4.0),
        FlyTo(np.array([12.0, 8.0]), 4.0), Land(),
    )  # fmt: skip
    made = Provenance(surveyed.file, surveyed.sha256, "test", "2026-01-01T00:00:00+00:00")
    return missions.plan_tasks(surveyed.orchard, surveyed.wishes, made, tasks)


def test_a_file_says_what_is_flown(tmp_path):
    kinds = [type(task) for task in tasks_of(tmp_path, TASKS)]
    assert kinds == [TakeOff, FlyTo, Hover, FlyTo, Land]


def test_legs_are_straight_from_rest_to_rest_and_hovers_last(mission):
    times = np.linspace(0.0, mission.trajectory.end, 2000)
    places, velocities, _ = mission.trajectory.sample(times)
    first = places[places[:, 0] < 11.99]
    np.testing.assert_allclose(first[:, 1:], [[0.0, 3.0]] * len(first), atol=1e-6)
    assert places[-1] == pytest.approx([12.0, 8.0, 4.0])
    corner = np.linalg.norm(places - [12.0, 0.0, 3.0], axis=1) < 1e-6
    stood = times[corner & (np.linalg.norm(velocities, axis=1) < 1e-6)]
    assert stood.max() - stood.min() >= 4.0


def test_the_mission_is_checked_saved_and_read_again(mission):
    again = missions.loads(missions.dumps(mission))
    np.testing.assert_allclose(again.waypoints_site, mission.waypoints_site)
    assert all(segment.leg is not Leg.ROW for segment in again.segments)  # nothing is sprayed


@pytest.mark.parametrize(
    ("said", "text"),
    [
        ("holds no task", ""),
        ("is no take-off", '[[task]]\ndo = "land"'),
        ("is no landing", TASKS.rsplit("[[task]]", 1)[0]),
        ("takes off in the air", TASKS.replace('"hover"\nfor_s = 4', AGAIN)),
        ("is 'jump'", TASKS.replace('"hover"', '"jump"')),
        ("for_s: is -4", TASKS.replace("= 4\n", "= -4\n")),
        ("to_m", TASKS.replace("to_m = [12.0, 0.0]", "to_m = [1e9, 0]")),
        ("is missing", TASKS.replace("to_m = [12.0, 0.0]", "")),
        ("is not known", TASKS.replace("for_s", "for_min = 1\nfor_s")),
        ("is no list of tables", "task = 3"),
    ],
)  # fmt: skip
def test_each_fault_is_told_with_its_task(tmp_path, said, text):
    with pytest.raises(InputError, match=said):
        tasks_of(tmp_path, text)


def test_what_cannot_be_flown_is_refused():
    surveyed = parse(SURVEY, "yard.survey.toml")
    made = Provenance(surveyed.file, surveyed.sha256, "test", "2026-01-01T00:00:00+00:00")
    low = (TakeOff(np.array([-4.0, 0.0]), 1.2), FlyTo(np.array([16.0, 0.0])), Land())
    with pytest.raises(InputError, match="above the canopy"):
        missions.plan_tasks(surveyed.orchard, surveyed.wishes, made, low)
    nowhere = (TakeOff(np.array([-4.0, 0.0]), 3.0), Hover(3.0), Land())
    with pytest.raises(InputError, match="leads nowhere"):
        missions.plan_tasks(surveyed.orchard, surveyed.wishes, made, nowhere)
