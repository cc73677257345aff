"""A flight that ends early comes down where nothing stands, as far as that is known."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.flight.boundary import area_of
from orchard_cli.flight.haven import REACH, Haven, Havens
from orchard_cli.flight.phases import step
from orchard_cli.flight.safety import Hazard, Phase, Request, Tolerances
from orchard_cli.flight.stage import Stage, Steer
from orchard_cli.geometry.area import Area
from orchard_cli.model.vehicle import FlightMode
from tests.laws.test_safety import decide, seen, vehicle
from tests.loop import (
    HEIGHT,
    blind,
    fly,
    phases,
    see,
    world_of,
)


class Known:
    """A map that has looked everywhere but in `unseen`, and found `occupied`."""

    def __init__(self, occupied=(), seen=True):
        self.cells = np.array(occupied, dtype=float).reshape(-1, 3)
        self._seen = seen

    def is_observed(self, places):
        return np.full(len(places), self._seen)


def nearest(havens, here, known):
    return havens.nearest(here, known, known.cells)


@settings(deadline=None)
@given(st.floats(-4, 16), st.floats(-4, 10))
def test_a_free_place_is_near_over_no_tree_and_inside(mission, x, y):
    fence = np.array([[-5.0, -5.0], [17.0, -5.0], [17.0, 11.0], [-5.0, 11.0]])
    found = nearest(Havens(mission, Area(fence)), np.array([x, y, HEIGHT]), Known())
    assert found is not None
    place = np.array(found.place_site)
    assert found.away == pytest.approx(np.linalg.norm(place - (x, y)), abs=1e-9)
    assert found.away <= REACH
    trunks = np.concatenate([row.trunks_site for row in mission.orchard.rows])
    assert np.linalg.norm(trunks - place, axis=1).min() >= 2.2 / 2 + 0.35
    assert Area(fence).margins(place[None])[0] >= 0.35


def test_what_the_map_has_found_there_or_on_the_way_is_not_landed_on(mission):
    havens, here = Havens(mission, area_of(mission)), np.array([6.0, 3.0, HEIGHT])
    assert nearest(havens, here, Known()) == Haven((6.0, 3.0), 0.0)
    box = [(6.0, 3.0, 1.0)]
    beside = nearest(havens, here, Known(box))
    assert 0.6 < beside.away <= 1.5
    wall = [(x, 3.5, HEIGHT) for x in np.arange(-2.0, 14.0, 0.1)]
    assert nearest(havens, here, Known(box + wall)).place_site[1] <= 3.0


def test_a_place_that_was_not_seen_is_not_known_to_be_free(mission):
    havens = Havens(mission, area_of(mission))
    assert nearest(havens, np.array([6.0, 3.0, HEIGHT]), Known(seen=False)) is None


def test_on_the_ground_and_where_nothing_is_allowed_there_is_no_place(mission):
    havens = Havens(mission, area_of(mission))
    assert nearest(havens, np.array([6.0, 3.0, 0.0]), Known()) is None
    small = np.array([[5.9, 2.9], [6.1, 2.9], [6.1, 3.1], [5.9, 3.1]])
    assert nearest(Havens(mission, Area(small)), np.array([6.0, 3.0, HEIGHT]), Known()) is None


NEAR, HERE = Haven((4.0, 3.0), 3.0), Haven((0.0, 0.0), 0.0)


@pytest.mark.parametrize("phase", [Phase.RESUME, Phase.ROUTE, Phase.AVOIDANCE, Phase.HOLD])
@pytest.mark.parametrize(
    "cause", [{"request": Request.LAND}, {"vehicle": vehicle(battery_share=0.05)}]
)
def test_an_early_landing_goes_to_the_free_place_and_then_lands(phase, cause):
    first = decide(phase, haven=NEAR, **cause)
    assert (first.stage.phase, first.steer) == (Phase.DIVERT, Steer.DIVERT)
    assert first.stage.place_site == NEAR.place_site
    assert not first.stage.as_planned
    assert "free place 3.0 m away" in first.stage.why
    there = step(first.stage, seen(route_done=True), 101.0, Tolerances()).stage
    assert there.phase is Phase.LANDING
    late = step(first.stage, seen(), 131.0, Tolerances()).stage
    assert late.phase is Phase.LANDING


def test_without_a_free_place_it_lands_where_it_is_and_says_so():
    landing = decide(Phase.ROUTE, request=Request.LAND).stage
    assert landing.phase is Phase.LANDING
    assert "where it is" in landing.why
    assert decide(Phase.ROUTE, request=Request.LAND, haven=HERE).stage.phase is Phase.LANDING


@pytest.mark.parametrize("ill", [{"frame_age": 2.0}, {"falling": 1.0}, {"off_track": 2.0}])
def test_who_does_not_see_or_follow_or_has_fallen_goes_nowhere(ill):
    assert decide(Phase.HOLD, request=Request.LAND, haven=NEAR, **ill).stage.phase is Phase.LANDING


def test_asked_again_on_the_way_it_lands_at_once_and_the_pilot_wins():
    assert decide(Phase.DIVERT, request=Request.LAND).stage.phase is Phase.LANDING
    assert decide(Phase.DIVERT, blocked=True).stage.cause is Hazard.BLOCKED
    taken = decide(Phase.DIVERT, vehicle=vehicle(mode=FlightMode.PILOT))
    assert (taken.stage.phase, taken.command) == (Phase.PILOT, None)


@pytest.mark.parametrize("late", [{"frame_age": 2.0}, {"planner_age": math.inf}])
def test_who_sees_nothing_for_a_moment_on_the_way_stands_and_waits(late):
    """To land at once could be on a tree. The wait ends with the time for the way."""
    waits = decide(Phase.DIVERT, vehicle=vehicle(battery_share=0.05), **late)
    assert (waits.stage.phase, waits.steer) == (Phase.DIVERT, Steer.STAND)
    assert decide(Phase.DIVERT).steer is Steer.DIVERT
    begun = Stage(Phase.DIVERT, 0.0, "asked")
    assert step(begun, seen(**late), 31.0, Tolerances()).stage.phase is Phase.LANDING


def test_a_route_that_is_over_lands_where_it_was_planned():
    landing = decide(Phase.ROUTE, route_done=True, haven=NEAR).stage
    assert (landing.phase, landing.as_planned) == (Phase.LANDING, True)
    home = step(Stage(Phase.RETURN, 0.0, "asked"), seen(route_done=True, haven=NEAR), 9.0,
                Tolerances()).stage  # fmt: skip
    assert home.phase is Phase.LANDING


@pytest.mark.parametrize("events", [[], [(30.6, blind), (33.6, see)]], ids=["seeing", "blinded"])
def test_asked_to_land_over_a_row_it_comes_down_beside_the_trees(mission, events):
    """On the way back it has seen what is beside the row: it lands there, not on a tree."""
    ending, ideal, ledger = fly(
        mission, world_of(mission), requests=[(30.0, Request.LAND)], events=events
    )
    assert not ending.as_planned
    assert phases(ledger)[-3:] == ["diverting", "landing", "ended"], ending
    trunks = np.concatenate([row.trunks_site for row in mission.orchard.rows])
    assert np.linalg.norm(trunks - ideal.position[:2], axis=1).min() >= 2.2 / 2 + 0.35
