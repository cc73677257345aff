"""Cases are pure, fair and kept whole; judgements look at the truth alone."""

import json
from dataclasses import replace

import numpy as np
import pytest

from orchard_cli.campaign import Outcome, Witness, judge, make_case, world_text
from orchard_cli.campaign.ledger import FILE, Ledger
from orchard_cli.campaign.summary import share, summary
from orchard_cli.commands.campaigns import orchards
from orchard_cli.commands.campaigns.flying import prepared
from orchard_cli.commands.pool import spread
from orchard_cli.errors import InputError
from orchard_cli.geometry.clearance import clearance
from orchard_cli.model.records import SafetyRecord, TruthRecord
from orchard_cli.model.vehicle import FlightMode, Landed, VehicleState
from orchard_cli.model.world import Pole, World
from orchard_cli.simulator.world_file import parse

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def case():
    return make_case(3, 1)


@pytest.fixture(scope="module")
def flown(case):
    return prepared(case)[0]


def test_a_case_is_a_function_of_seed_and_number_alone():
    texts = {(s, k): world_text(make_case(s, k).world) for s in (0, 1) for k in (0, 1, 2)}
    assert len(set(texts.values())) == 6
    for (seed, number), text in reversed(texts.items()):
        assert world_text(make_case(seed, number).world) == text


@pytest.mark.parametrize("number", range(12))
def test_a_world_is_told_whole_by_its_file(number):
    world = make_case(5, number).world
    read = parse(world_text(world), "world.toml")
    assert len(read.people) == len(world.people)
    for kind in ("trees", "poles"):
        assert getattr(read, kind) == getattr(world, kind)
    np.testing.assert_allclose(read.wind.velocity_site, world.wind.velocity_site, atol=1e-12)
    points = np.random.default_rng(0).uniform((-5, -5, 0), (25, 20, 6), (50, 3))
    for part in ("obstacles", "trees"):
        measured = [getattr(clearance(w, points), part) for w in (read, world)]
        np.testing.assert_allclose(*measured, atol=1e-9)
    np.testing.assert_allclose(read.noise.attitude, world.noise.attitude, atol=1e-12)
    assert replace(read.noise, attitude=0.0, radar_angle=0.0) == replace(
        world.noise, attitude=0.0, radar_angle=0.0
    )


@pytest.mark.parametrize("number", range(6))
def test_a_case_can_be_planned_and_leaves_take_off_and_landing_free(number):
    case = make_case(11, number)
    mission, world, _ = prepared(case)
    world = replace(world, trees=())
    for x, y in (mission.takeoff_site, mission.landing_site):
        column = np.array([(x, y, z) for z in np.linspace(0.0, 4.0, 9)])
        for time in range(0, 120, 5):
            assert clearance(world, column, np.full(9, float(time))).obstacles.min() > 2.0


def told(mission, path, contact_at=None, armed=False):
    """What a witness sees of a perfect flight along (n, 3) m, 0.1 s apart."""
    seen = Witness()
    for k, (here, there) in enumerate(zip(path, [*path[1:], path[-1]], strict=True)):
        touched = "pole 1" if contact_at is not None and k >= contact_at else ""
        seen.write(TruthRecord(0.1 * k, here, (there - here) / 0.1, UPRIGHT, touched))
        state = VehicleState(
            0.1 * k, here, np.zeros(3), UPRIGHT, np.zeros(3), armed or k < len(path) - 1,
            FlightMode.OFFBOARD, Landed.IN_AIR, 0.1 * k, 1.0, 16.0, True,
        )  # fmt: skip
        seen.write(state)
    for at, phase in ((0.0, "route"), (0.1 * len(path), "landing"), (0.1 * len(path), "ended")):
        seen.write(SafetyRecord(at, phase, "", ""))
    return seen


def path_of(mission):
    path = mission.trajectory.sample(np.arange(0.0, mission.trajectory.end, 0.1))[0]
    down = np.repeat(path[-1:], 20, axis=0)
    down[:, 2] = np.append(np.linspace(path[-1, 2], 0.1, 18), [0.1, 0.1])
    return np.concatenate([path, down])


def test_a_whole_route_and_a_landing_where_it_should_be_is_completed(case, flown):
    bare = World("bare", trees=case.world.trees[:0])
    found = judge(flown, bare, told(flown, path_of(flown)), True, "landed")
    assert found.outcome is Outcome.COMPLETED
    assert found.over_ideal == pytest.approx(2.0, abs=0.3)
    assert found.clearance == np.inf


def test_half_a_route_is_a_safe_end_whatever_the_flight_says_of_itself(flown):
    path = path_of(flown)
    half = np.concatenate(
        [path[: len(path) // 2], path[len(path) // 2] * [1, 1, 0] + [[0, 0, 0.1]] * 2]
    )
    found = judge(flown, World("bare"), told(flown, half), True, "landed")
    assert found.outcome is Outcome.SAFE


def test_what_hangs_in_the_air_or_is_armed_has_no_safe_end(flown):
    path = path_of(flown)
    assert judge(flown, World("bare"), told(flown, path[:-5]), True, "").outcome is Outcome.UNSAFE
    armed = told(flown, path, armed=True)
    assert judge(flown, World("bare"), armed, True, "").outcome is Outcome.UNSAFE


def test_a_contact_is_one_and_the_fall_after_it_counts_no_more(flown):
    path = path_of(flown)
    at = len(path) // 3
    x, y, z = path[at]
    world = World("pole", poles=(Pole(x, y + 0.5, 0.1, z + 1.0), Pole(*path[2 * at, :2], 0.1, 9.0)))
    found = judge(flown, world, told(flown, path, contact_at=at), True, "landed")
    assert found.outcome is Outcome.CONTACT
    assert found.contact == "pole 1"
    assert found.nearest["pole"] == pytest.approx(0.4, abs=0.1)


def test_intervals_are_clopper_and_pearsons():
    none = share(0, 1000)
    assert none["low"] == 0.0
    assert none["high"] == pytest.approx(1 - 0.025 ** (1 / 1000))
    assert share(0, 0)["high"] is None


def record(number, outcome="completed", nearest=1.2, contact=""):
    return {
        "seed": 0, "case": number, "outcome": outcome, "why": "landed", "contact": contact,
        "clearance_m": nearest, "nearest_m": {"pole": nearest}, "person_m": None, "kept": True,
        "over_ideal_s": 1.0, "replans": 1, "holds": 0, "left_out": 0,
    }  # fmt: skip


def test_a_summary_counts_each_flight_once():
    found = summary(
        [
            record(0),
            record(1, nearest=0.8),
            record(2, "contact", 0.3, "pole 1"),
            record(3, "safe end"),
        ]
    )
    assert (found["flights"], found["contacts"], found["completed"]) == (4, 1, 2)
    assert (found["near_misses"], found["near_misses_wide"], found["safe_ends"]) == (1, 3, 1)
    assert [one["case"] for one in found["failures"]] == [1, 2]
    assert found["by_thing"]["pole"]["contacts"] == 1


def test_a_campaign_goes_on_where_it_was_killed_and_mixes_nothing(tmp_path, monkeypatch):
    flown = []

    def fly(task):
        flown.append(task.number)
        return record(task.number)

    monkeypatch.setattr(orchards, "fly_one", fly)
    campaign = orchards.Campaign(3, 0, "guided", (212, 120), tmp_path)
    first = orchards.run(campaign, 1, None, True)
    with open(tmp_path / FILE, "ab") as file:
        file.write(json.dumps(record(3)).encode()[:20])  # killed while writing
    again = orchards.run(replace(campaign, flights=4), 1, None, True)
    assert flown == [0, 1, 2, 3]
    assert again["flights"] == 4
    assert orchards.run(campaign, 1, None, True) == first
    with pytest.raises(InputError, match="other inputs"):
        orchards.run(replace(campaign, seed=1), 1, None, True)
    (tmp_path / FILE).write_text("[]\n")
    with pytest.raises(InputError):
        Ledger(tmp_path, campaign.inputs, ("case",))


def test_every_task_comes_back_once_from_any_number_of_workers():
    for workers in (1, 2):
        assert sorted(spread(abs, [-3, 2, -1], workers, quiet=True)) == [1, 2, 3]
