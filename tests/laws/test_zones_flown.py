"""What `zones` promises, flown with perfect tracking past things that perfect eyes see."""

from dataclasses import replace

import numpy as np
import pytest

from orchard_cli.avoidance import Zones
from orchard_cli.model.mission import Limits
from orchard_cli.model.obstacles import Category, Detection, Obstacle, Sighting

from ..pole_world import PoleMap, fly, straight_route

LIMITS = Limits()
ROUTE = straight_route(40.0)
SOMEWHERE = Detection(Category.POLE, 0.9, 0.0, 0.0, 1.0, 1.0)


class PerfectEyes:
    """Sees upright things (x, y, radius) of one category, bottom and top, before the vehicle."""

    needs = frozenset()

    def __init__(self, things, category=Category.POLE, bottom=0.0, top=8.0, far=9.0):
        self.things, self.far = things, far
        self.detection = replace(SOMEWHERE, category=category)
        self.bottom, self.top = bottom, top

    def look(self, frame, pose, colour):
        w, _, _, z = pose.site_from_body
        nose = np.array([w * w - z * z, 2 * w * z])
        seen = []
        for x, y, radius in self.things:
            away = np.array([x, y]) - pose.position_site[:2]
            depth, side = away @ nose, abs(away @ [-nose[1], nose[0]])
            if 0.3 < depth < self.far and side < depth * 0.94:
                place = np.array([x, y, (self.bottom + self.top) / 2])
                seen.append(
                    Obstacle(self.detection, depth - radius, 2 * radius, place, self.bottom,
                             self.top)
                )  # fmt: skip
        return Sighting(tuple(seen))


def past(poles, **kwargs):
    return fly(Zones(PerfectEyes(poles)), ROUTE, PoleMap(poles), **kwargs)


@pytest.mark.parametrize("offset", [0.0, 0.1, -0.35, 0.8])
def test_a_pole_is_passed_clear_gently_and_back_on_the_line(offset):
    poles = [(20.0, offset, 0.15)]
    flight = past(poles)
    assert flight.clearance(poles) >= LIMITS.clearance
    assert np.abs(flight.positions[:, 1]).max() <= 1.9
    assert flight.accelerations.max() <= LIMITS.acceleration * 1.04
    assert flight.speeds.max() <= LIMITS.speed * 1.03
    assert "Stop" not in flight.kinds()
    behind = flight.positions[flight.positions[:, 0] > 27]
    assert np.abs(behind[:, 1]).max() < 0.01
    np.testing.assert_allclose(flight.positions[:, 2], 3.5, atol=1e-9)
