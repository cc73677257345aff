"""What the simulated vehicle touches breaks it, and what touches nothing flies as before."""

from __future__ import annotations

import multiprocessing

import numpy as np
import pytest

from orchard_cli.avoidance import Blind
from orchard_cli.flight.gear import Gear
from orchard_cli.flight.onboard import Onboard
from orchard_cli.flight.reporter import Reporter
from orchard_cli.flight.runner import Flight
from orchard_cli.flight.worker import InlineWorker
from orchard_cli.geometry.clearance import clearance
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.mission import plan
from orchard_cli.model.mission import Provenance
from orchard_cli.model.records import TruthRecord
from orchard_cli.model.site import HeightReference, Orchard, SiteOrigin, TreeRow
from orchard_cli.model.vehicle import Command, FlightMode, Setpoint
from orchard_cli.model.wishes import FlightWishes
from orchard_cli.model.world import Person, Pole, Tree, Wind, World
from orchard_cli.simulator import LockstepSimulator, SimulatorSettings
from orchard_cli.simulator.board import Board
from orchard_cli.simulator.body import X500
from orchard_cli.simulator.faults import Appearance
from tests.ideal import Ledger

ORIGIN = SiteOrigin(23.68, 112.68, 30.0, HeightReference.AMSL, 0.6)
GUSTY = Wind(np.array([0.5, 0.3, 0.0]), gust=0.4)
FAR, NEAR = Pole(50.0, 0.0, 0.1, 5.0), Pole(4.0, 0.0, 0.1, 5.0)


def flown(*poles: Pole) -> tuple[LockstepSimulator, list[TruthRecord]]:
    """Up to 3 m and 8 m along x, whatever stands there."""
    world = World("field", poles=poles, wind=GUSTY, seed=5)
    sim = LockstepSimulator(world, ORIGIN, (0.0, 0.0), 0.0, SimulatorSettings(camera=None))
    vehicle, clock = sim.vehicle, sim.clock
    clock.sleep_until(3.0)
    vehicle.command(Command.ARM)
    vehicle.command(Command.TAKEOFF, 3.0)
    clock.sleep_until(10.0)
    for tick in range(400):
        along = np.array([min(0.02 * tick, 8.0), 0.0, 3.0])
        vehicle.send(Setpoint(clock.now(), along, np.zeros(3), np.zeros(3), 0.0))
        if tick == 0:
            vehicle.command(Command.OFFBOARD)
        clock.sleep_until(clock.now() + 0.02)
    return sim, list(sim.truth.take())


def bits(records: list[TruthRecord]) -> bytes:
    return b"".join(
        array.tobytes()
        for one in records
        for array in (one.position_site, one.velocity_site, one.site_from_body)
    )


def test_a_pole_in_the_way_is_named_from_the_touch_on_and_the_vehicle_falls() -> None:
    _, records = flown(FAR, NEAR)
    first = next(k for k, one in enumerate(records) if one.contact)
    assert {one.contact for one in records[:first]} == {""}
    assert {one.contact for one in records[first:]} == {"pole 2"}
    world = World("field", poles=(FAR, NEAR))
    points = np.array([one.position_site for one in records])
    away = clearance(world, points).obstacles
    assert away[first] <= X500.radius < away[first - 1]
    assert records[first].position_site[2] > 2.0
    assert points[-1, 2] == pytest.approx(0.0, abs=0.01)
    assert np.abs(records[-1].velocity_site).max() < 1e-3


def test_up_to_the_touch_it_flies_the_same_bits_as_in_a_free_field() -> None:
    _, free = flown()
    _, passed = flown(FAR)
    _, touched = flown(NEAR)
    assert {one.contact for one in free + passed} == {""}
    assert bits(passed) == bits(free)
    first = next(k for k, one in enumerate(touched) if one.contact)
    assert bits(touched[: first + 1]) == bits(free[: first + 1])
    assert bits(touched) == bits(flown(NEAR)[1])


def test_the_autopilot_is_not_told() -> None:
    sim, records = flown(NEAR)
    assert records[-1].contact == "pole 1"
    state = sim.vehicle.state()
    assert state.armed
    assert state.mode is FlightMode.OFFBOARD


@pytest.mark.parametrize(
    "thing",
    [{"trees": (Tree(0.3, 0.0),)}, {"people": (Person(np.zeros(2), np.array([0.1, 0.0]), 0.1),)}],
)
def test_standing_beside_something_is_no_contact_but_taking_off_into_it_is(thing) -> None:
    sim = LockstepSimulator(
        World("crowded", **thing), ORIGIN, (0.0, 0.0), 0.0, SimulatorSettings(camera=None)
    )
    sim.clock.sleep_until(4.0)
    assert {one.contact for one in sim.truth.take()} == {""}
    sim.vehicle.command(Command.ARM)
    sim.vehicle.command(Command.TAKEOFF, 3.0)
    sim.clock.sleep_until(8.0)
    (kind,) = thing
    assert sim.truth.take()[-1].contact == {"trees": "tree 1", "people": "person 1"}[kind]


def test_the_board_carries_the_name_from_the_touch_on() -> None:
    board = Board(multiprocessing.get_context("spawn"), None)
    level = np.array([1.0, 0.0, 0.0, 0.0])
    for time, contact in ((0.02, ""), (0.04, "person 12"), (0.06, "person 12")):
        board.put_truth(TruthRecord(time, np.full(3, time), np.zeros(3), level, contact))
    _, records = board.truth(0)
    assert [(one.time, one.contact) for one in records] == [
        (0.02, ""), (0.04, "person 12"), (0.06, "person 12"),
    ]  # fmt: skip


def test_a_blind_flight_into_a_pole_ends_by_itself_off_plan_and_on_the_ground() -> None:
    trunks = np.column_stack([np.arange(3) * 3.0, np.zeros(3)])
    row = TreeRow(trunks, np.zeros(3), np.full(3, 2.2))
    mission = plan(
        Orchard("short row", ORIGIN, (row,)), FlightWishes(3.5),
        Provenance("test", "0" * 64, "0", "2026-01-01T00:00:00Z"),
    )  # fmt: skip
    x, y = (float(v) for v in mission.takeoff_site)
    world = World("short row", poles=(Pole(1.5, 0.0, 0.15, 8.0),))
    sim = LockstepSimulator(
        world, ORIGIN, (x, y), 0.0, SimulatorSettings(camera=(212, 120)), mission.takeoff_ground
    )
    ledger = Ledger()
    gear = Gear(
        vehicle=sim.vehicle,
        camera=sim.camera,
        worker=InlineWorker(Onboard(OccupancyGrid(), Blind(), mission.limits).cycle),
        errands=InlineWorker(lambda errand: errand()),
        clock=sim.clock,
        recorder=ledger,
        reporter=Reporter(mission, ledger, ledger, 0.0),
        operator=ledger,
        guard=ledger,
        truth=sim.truth,
    )
    ending = Flight(mission, gear).run()
    assert not ending.as_planned
    last = ledger.of(TruthRecord)[-1]
    assert last.contact == "pole 1"
    assert last.position_site[2] == pytest.approx(0.0, abs=0.01)


def test_what_appears_in_the_way_is_touched_as_well():
    world = World("field", seed=5)
    sim = LockstepSimulator(world, ORIGIN, (0.0, 0.0), 0.0, SimulatorSettings(camera=None))
    sim.clock.sleep_until(3.0)
    sim.vehicle.command(Command.ARM)
    sim.vehicle.command(Command.TAKEOFF, 3.0)
    sim.clock.sleep_until(9.0)
    assert sim.truth.take()[-1].contact == ""
    sim.inject(Appearance(Pole(0.3, 0.0, 0.1, 5.0)))
    sim.clock.sleep_until(9.5)
    assert sim.truth.take()[-1].contact == "pole 1"
