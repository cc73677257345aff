"""What every avoidance system owes to the flight, whatever it decides."""

import numpy as np
import pytest

from orchard_cli.avoidance import Astar, Blind, Dfa, Ego, Guided, Zones
from orchard_cli.motion.situation import Avoid, Keep, Stop
from orchard_cli.perception import DepthDetector, RgbdEyes

from ..pole_world import PoleMap, same_until, situation, straight_route


def zones():
    return Zones(RgbdEyes(DepthDetector()))


SYSTEMS = [Guided, Ego, zones, Astar, Dfa, Blind]
ROUTE = straight_route(40.0)
WORLDS = {
    "empty": [],
    "pole": [(20.0, 0.1, 0.15)],
    "fence": [(20.0, y, 0.15) for y in np.arange(-9, 9.1, 0.8)],
    "very near": [(16.2, 0.0, 0.15)],
    "behind": [(12.0, 0.0, 0.15)],
}


def ask(make, world, now=15.0):
    poles = WORLDS[world]
    grid, system = PoleMap(poles, known=True), make()
    for earlier in (0.2, 0.1) if system.needs else ():  # radar believes what it sees twice
        t = now - earlier
        system.plan(situation(t, t + 0.2, ROUTE, ROUTE, grid, poles=poles))
    return system.plan(situation(now, now + 0.2, ROUTE, ROUTE, grid, poles=poles))


@pytest.mark.parametrize("make", SYSTEMS)
@pytest.mark.parametrize("world", WORLDS)
def test_answers_with_a_verdict_that_says_why(make, world):
    verdict = ask(make, world)
    assert isinstance(verdict, Keep | Avoid | Stop)
    assert verdict.why
    assert all(ms >= 0 for ms in verdict.stages_ms.values())


@pytest.mark.parametrize("make", SYSTEMS)
@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize("now", [0.0, 1.3, 15.0, 39.9])
def test_changes_nothing_before_the_commit_time(make, world, now):
    """PEERS: setpoints that jump; replans from where the vehicle is not."""
    verdict = ask(make, world, now)
    if not isinstance(verdict, Keep):
        same_until(ROUTE, verdict.trajectory, now, now + 0.2)
    if isinstance(verdict, Avoid):
        assert now + 0.2 <= verdict.begin < verdict.rejoin


@pytest.mark.parametrize("make", SYSTEMS)
def test_keeps_a_free_way(make):
    assert isinstance(ask(make, "empty"), Keep)
    assert isinstance(ask(make, "behind"), Keep)


@pytest.mark.parametrize("make", SYSTEMS)
@pytest.mark.parametrize("world", WORLDS)
def test_decides_the_same_twice(make, world):
    first, second = ask(make, world), ask(make, world)
    assert type(first) is type(second)
    assert first.why == second.why
    if not isinstance(first, Keep):
        a, b = first.trajectory.control_points_site, second.trajectory.control_points_site
        assert a.tobytes() == b.tobytes()


@pytest.mark.parametrize("make", SYSTEMS)
def test_a_stop_ends_at_rest(make):
    verdict = ask(make, "fence")
    if isinstance(verdict, Stop):
        end = verdict.trajectory.at(verdict.trajectory.end)
        assert np.linalg.norm(end.velocity_site) < 1e-9
        assert np.linalg.norm(end.acceleration_site) < 1e-9


@pytest.mark.parametrize("make", SYSTEMS)
def test_has_a_name_for_the_command_line(make):
    assert make().name in ("guided", "ego", "zones", "dfa", "astar", "none")
