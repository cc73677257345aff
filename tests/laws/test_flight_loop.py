"""The whole loop on an ideal vehicle: plan in, landing out, with and without faults."""

import numpy as np
import pytest

from orchard_cli.avoidance import Blind, Guided
from orchard_cli.flight.onboard import Onboard
from orchard_cli.flight.reporter import Reporter
from orchard_cli.flight.runner import Flight, Gear
from orchard_cli.flight.safety import Request
from orchard_cli.flight.worker import InlineWorker
from orchard_cli.geometry.clearance import clearance
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.mission import plan
from orchard_cli.model.mission import Provenance
from orchard_cli.model.records import SafetyRecord, SprayRecord
from orchard_cli.model.site import HeightReference, Orchard, SiteOrigin, TreeRow
from orchard_cli.model.vehicle import Command, FlightMode
from orchard_cli.model.wishes import FlightWishes
from orchard_cli.model.world import Pole, Tree, World
from tests.ideal import IdealWorld, Ledger

HEIGHT = 3.5


def row(y, n=5):
    trunks = np.column_stack([np.arange(n) * 3.0, np.full(n, y)])
    return TreeRow(trunks, np.zeros(n), np.full(n, 2.2))


@pytest.fixture(scope="module")
def mission():
    origin = SiteOrigin(23.45, 113.2, 20.0, HeightReference.ELLIPSOID, 0.3)
    orchard = Orchard("test orchard", origin, (row(0.0), row(6.0)))
    provenance = Provenance("test", "0" * 64, "0", "2026-01-01T00:00:00Z")
    return plan(orchard, FlightWishes(HEIGHT), provenance)


def world_of(mission, poles=()):
    trees = tuple(
        Tree(float(x), float(y), height=2.2) for r in mission.orchard.rows for x, y in r.trunks_site
    )
    return World("test world", trees=trees, poles=poles)


def fly(mission, world, *, system=None, requests=(), events=(), refuse=None):
    x, y = mission.takeoff_site
    ideal = IdealWorld(world, (float(x), float(y)))
    ideal.events = list(events)
    ideal.refuse = refuse or {}
    ledger = Ledger(requests)
    ledger.clock = ideal.now
    onboard = Onboard(OccupancyGrid(), system or Guided(), mission.limits)
    gear = Gear(
        vehicle=ideal,
        camera=ideal,
        worker=InlineWorker(onboard.cycle),
        clock=ideal,
        recorder=ledger,
        reporter=Reporter(mission, ledger, ledger, 0.0),
        operator=ledger,
        guard=ledger,
    )
    return Flight(mission, gear).run(), ideal, ledger


def phases(ledger):
    seen = []
    for record in ledger.of(SafetyRecord):
        if not seen or seen[-1] != record.phase:
            seen.append(record.phase)
    return seen


def path(ideal):
    return np.array([s.position_site for s in ideal.setpoints])


def test_a_free_route_is_flown_to_its_end_and_landed(mission):
    ending, ideal, ledger = fly(mission, world_of(mission))
    assert ending.as_planned, ending
    assert phases(ledger) == ["preflight", "take-off", "resume", "route", "landing", "ended"]
    assert ideal.position[:2] == pytest.approx(mission.landing_site, abs=0.01)
    sprayed = {r.row for r in ledger.of(SprayRecord) if r.on}
    assert sprayed == {0, 1}


def test_poles_on_the_row_are_passed_at_the_clearance_and_the_height_is_kept(mission):
    world = world_of(mission, (Pole(7.5, 0.0, 0.15, 8.0), Pole(4.5, 6.0, 0.15, 8.0)))
    ending, ideal, ledger = fly(mission, world)
    assert ending.as_planned, ending
    assert "avoidance" in phases(ledger)
    points = path(ideal)
    assert clearance(world, points).obstacles.min() >= mission.limits.clearance
    assert np.abs(points[:, 2] - HEIGHT).max() < 0.01
    off = [r for r in ledger.of(SprayRecord) if r.why == "no spray in avoidance"]
    assert off


def test_without_avoidance_the_same_pole_would_have_been_hit(mission):
    world = world_of(mission, (Pole(7.5, 0.0, 0.15, 8.0),))
    _, ideal, _ = fly(mission, world, system=Blind())
    assert clearance(world, path(ideal)).obstacles.min() < 0


def test_the_pilot_takes_over_and_nothing_is_streamed_any_more(mission):
    def take_over(ideal):
        ideal.mode = FlightMode.PILOT
        ideal.taken = len(ideal.setpoints)

    def disarm(ideal):
        ideal.armed = False

    ending, ideal, ledger = fly(
        mission, world_of(mission), events=[(30.0, take_over), (40.0, disarm)]
    )
    assert not ending.as_planned
    assert phases(ledger)[-2:] == ["pilot", "ended"]
    assert len(ideal.setpoints) <= ideal.taken + 1


def test_a_camera_that_fails_for_a_while_means_a_stop_and_then_the_rest_of_the_route(mission):
    def blind(ideal):
        ideal.blind = True

    def see(ideal):
        ideal.blind, ideal._frames = False, int(ideal.time * 15) + 1

    ending, ideal, ledger = fly(mission, world_of(mission), events=[(30.0, blind), (36.0, see)])
    assert ending.as_planned, ending
    assert phases(ledger)[3:7] == ["route", "hold", "resume", "route"]
    steps = np.linalg.norm(np.diff(path(ideal), axis=0), axis=1)
    assert steps.max() < 1.05 * mission.limits.speed * 0.02
    assert {r.row for r in ledger.of(SprayRecord) if r.on} == {0, 1}


def test_a_camera_that_never_comes_back_ends_in_a_landing(mission):
    def blind(ideal):
        ideal.blind = True

    ending, _, ledger = fly(mission, world_of(mission), events=[(30.0, blind)])
    assert not ending.as_planned
    assert phases(ledger)[-3:] == ["hold", "landing", "ended"]


def test_a_wall_across_the_route_means_hold_then_back_home(mission):
    wall = tuple(Pole(4.5, float(y), 0.25, 8.0) for y in np.arange(-20, 26, 0.5))
    world = world_of(mission, wall)
    ending, ideal, ledger = fly(mission, world)
    assert not ending.as_planned
    assert phases(ledger)[-4:] == ["hold", "return", "landing", "ended"]
    assert clearance(world, path(ideal)).obstacles.min() > mission.limits.airframe_radius
    assert ideal.position[:2] == pytest.approx(mission.takeoff_site, abs=0.7)


@pytest.mark.parametrize(
    ("request_", "end"), [(Request.RETURN, "return"), (Request.LAND, "landing")]
)
def test_the_operator_holds_and_then_chooses(mission, request_, end):
    ending, _, ledger = fly(
        mission, world_of(mission), requests=[(30.0, Request.HOLD), (34.0, request_)]
    )
    assert not ending.as_planned
    after = phases(ledger)
    assert after[after.index("hold") + 1] == end


def test_an_operator_who_continues_gets_the_whole_route(mission):
    ending, _, _ = fly(
        mission, world_of(mission), requests=[(30.0, Request.HOLD), (34.0, Request.CONTINUE)]
    )
    assert ending.as_planned, ending


def test_an_arming_refusal_is_told_in_the_autopilots_words(mission):
    ending, _, _ = fly(mission, world_of(mission), refuse={Command.ARM: "GPS fix too low"})
    assert "GPS fix too low" in ending.why


def test_a_link_that_falls_silent_gets_no_setpoint(mission):
    def cut(ideal):
        ideal.deaf = True

    def mend(ideal):
        ideal.deaf = False
        ideal.mode = FlightMode.HOLD

    ending, ideal, ledger = fly(mission, world_of(mission), events=[(30.0, cut), (40.0, mend)])
    assert ending.as_planned, ending
    silent = [s.time for s in ideal.setpoints if 30.7 < s.time < 40.0]
    assert not silent
    assert "hold" in phases(ledger)
