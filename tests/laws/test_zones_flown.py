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


def with_eyes(eyes, grid=None, **kwargs):
    grid = grid or PoleMap([])
    return fly(Zones(eyes), ROUTE, grid, **kwargs)


def test_a_low_tree_is_leapt_and_the_height_taken_up_again():
    flight = with_eyes(PerfectEyes([(20.0, 0.0, 1.0)], Category.TREE, top=3.2))
    heights = flight.positions[:, 2]
    over = np.abs(flight.positions[:, 0] - 20.0) < 1.0
    assert heights[over].min() >= 3.2 + LIMITS.clearance
    assert heights.max() <= 3.2 + LIMITS.clearance + 0.6
    np.testing.assert_allclose(flight.positions[:, 1], 0.0, atol=1e-6)
    behind = flight.positions[:, 0] > 28.0
    np.testing.assert_allclose(heights[behind], 3.5, atol=0.01)
    assert flight.accelerations.max() <= LIMITS.acceleration * 1.04


def test_a_person_ahead_is_waited_for():
    eyes = PerfectEyes([(20.0, 0.5, 0.3)], Category.PERSON, top=1.8)

    def leave(now, grid):
        if now > 30.0:
            eyes.things = []

    flight = with_eyes(eyes, each=leave, longest=80.0)
    assert "Stop" in flight.kinds()
    assert any(verdict.alarm for _, verdict in flight.verdicts)
    assert flight.accelerations.max() <= LIMITS.acceleration * 1.04
    stood = flight.positions[(flight.speeds < 1e-6) & (flight.positions[:, 0] > 2.0)]
    assert stood[:, 0].min() < 18.0
    assert np.linalg.norm(flight.positions[-1] - ROUTE.at(ROUTE.end).position_site) < 0.01


def test_a_wire_across_is_stopped_before():
    flight = with_eyes(PerfectEyes([(20.0, 0.0, 0.05)], Category.WIRE, bottom=3.4, top=3.6),
                       longest=60.0)  # fmt: skip
    assert "Stop" in flight.kinds()
    assert flight.positions[:, 0].max() < 20.0 - LIMITS.clearance
    assert flight.speeds[-1] < 1e-6


def test_what_the_eyes_do_not_know_is_braked_before():
    """The map disposes."""
    poles = [(20.0, 0.0, 0.15)]
    flight = with_eyes(PerfectEyes([]), PoleMap(poles), longest=60.0)
    assert flight.clearance(poles) >= LIMITS.clearance
    assert flight.speeds[-1] < 1e-6
