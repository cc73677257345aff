"""What `astar` promises, flown with perfect tracking past poles that a perfect camera discovers."""

import numpy as np
import pytest

from orchard_cli.avoidance import Astar, AstarSettings
from orchard_cli.avoidance.astar.system import warning_distance
from orchard_cli.model.mission import Limits
from orchard_cli.motion.situation import Avoid, Stop

from ..pole_world import PoleMap, avoids, fly, situation, straight_route

LIMITS = Limits()
ROUTE = straight_route(30.0)


@pytest.mark.parametrize("offset", [0.0, -0.35, 0.8])
def test_a_pole_is_passed_clear_gently_and_back_on_the_line(offset):
    poles = [(15.0, offset, 0.15)]
    flight = fly(Astar(), ROUTE, PoleMap(poles))
    assert flight.clearance(poles) >= LIMITS.clearance
    assert flight.accelerations.max() <= LIMITS.acceleration * 1.04
    assert flight.speeds.max() <= LIMITS.speed * 1.03
    assert flight.kinds() == ["Avoid"]  # PEERS: flips for ever between two ways round
    behind = flight.positions[flight.positions[:, 0] > 22]
    assert np.abs(behind[:, 1]).max() < 0.02
    np.testing.assert_allclose(flight.positions[:, 2], 3.5, atol=1e-9)  # the height is kept


def test_a_fence_is_stopped_before_with_the_clearance_kept():
    fence = [(15.0, y, 0.15) for y in np.arange(-9, 9.1, 0.8)]
    flight = fly(Astar(), ROUTE, PoleMap(fence), longest=20.0)
    assert any(isinstance(v, Stop) for _, v in flight.verdicts)
    assert flight.clearance(fence) >= LIMITS.clearance
    assert flight.speeds[-1] < 1e-6


def test_nothing_is_done_before_the_warning_distance():
    """Huang 2021, §2.6: 3 m; more where braking needs it."""
    grid = PoleMap([(15.0, 0.0, 0.15)], known=True)
    fast = situation(10.0, 10.2, ROUTE, ROUTE, grid)
    far = warning_distance(fast, AstarSettings())
    assert far > 3.0 + 1e-9
    slow_route = straight_route(30.0, speed=0.3, interval=0.5)
    slow = situation(10.0, 10.2, slow_route, slow_route, grid)
    assert warning_distance(slow, AstarSettings()) == 3.0
    flight = fly(Astar(), ROUTE, PoleMap([(15.0, 0.0, 0.15)], known=True), longest=20.0)
    began = avoids(flight)[0].begin
    assert 15.0 - 0.15 - ROUTE.at(began).position_site[0] <= far


def test_a_low_wall_is_leapt_in_three_dimensions():
    """2D, as published, must stop before it; the 3D variant goes over and comes down again."""
    wall = [(15.0, y, 0.15) for y in np.arange(-9, 9.1, 0.2)]

    class Low(PoleMap):
        def window(self, lower_site, upper_site):
            full = super().window(lower_site, upper_site)
            levels = full.origin_site[2] + full.cell * np.arange(full.occupied.shape[2])
            return type(full)(full.origin_site, full.cell, full.occupied & (levels < 3.45))

    asked = situation(12.7, 12.9, ROUTE, ROUTE, Low(wall, known=True))
    assert not isinstance(Astar().plan(asked), Avoid)
    verdict = Astar(AstarSettings(three_d=True)).plan(asked)
    assert isinstance(verdict, Avoid)
    places = verdict.trajectory.sample(np.arange(12.9, verdict.rejoin, 0.05))[0]
    over = np.abs(places[:, 0] - 15.0) < 0.2
    assert over.any()
    assert places[over, 2].min() >= 3.5 + AstarSettings().vertical
    assert abs(verdict.trajectory.at(verdict.rejoin + 1.0).position_site[2] - 3.5) < 0.05
