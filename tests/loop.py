"""The flight loop on an ideal vehicle, over two short rows."""

import numpy as np

from orchard_cli.avoidance import Guided
from orchard_cli.flight.boundary import area_of
from orchard_cli.flight.gear import Gear
from orchard_cli.flight.haven import Havens
from orchard_cli.flight.onboard import Onboard
from orchard_cli.flight.reporter import Reporter
from orchard_cli.flight.runner import Flight
from orchard_cli.flight.worker import InlineWorker
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.mission import plan
from orchard_cli.model.mission import Provenance
from orchard_cli.model.records import (
    SafetyRecord,
)
from orchard_cli.model.site import HeightReference, Orchard, SiteOrigin, TreeRow
from orchard_cli.model.wishes import FlightWishes
from orchard_cli.model.world import Tree, World
from tests.ideal import IdealWorld, Ledger

HEIGHT = 3.5


def row(y, n=5):
    trunks = np.column_stack([np.arange(n) * 3.0, np.full(n, y)])
    return TreeRow(trunks, np.zeros(n), np.full(n, 2.2))


def two_rows():
    """The mission over them."""
    origin = SiteOrigin(23.45, 113.2, 20.0, HeightReference.ELLIPSOID, 0.3)
    orchard = Orchard("test orchard", origin, (row(0.0), row(6.0)))
    provenance = Provenance("test", "0" * 64, "0", "2026-01-01T00:00:00Z")
    return plan(orchard, FlightWishes(HEIGHT), provenance)


def world_of(mission, poles=()):
    trees = tuple(
        Tree(float(x), float(y), height=2.2) for r in mission.orchard.rows for x, y in r.trunks_site
    )
    return World("test world", trees=trees, poles=poles)


def fly(
    mission, world, *, system=None, requests=(), events=(), refuse=None, prepare=None, latency=0.04,
    load=None,
):  # fmt: skip
    x, y = mission.takeoff_site
    ideal = IdealWorld(world, (float(x), float(y)))
    ideal.events = list(events)
    if prepare is not None:
        prepare(ideal)
    ideal.refuse = refuse or {}
    ledger = Ledger(requests)
    ledger.clock = ideal.now
    area = area_of(mission)
    onboard = Onboard(
        OccupancyGrid(), system or Guided(), mission.limits, area, Havens(mission, area)
    )
    gear = Gear(
        vehicle=ideal,
        camera=ideal,
        worker=InlineWorker(onboard.cycle, latency),
        errands=InlineWorker(lambda errand: errand()),
        clock=ideal,
        recorder=ledger,
        reporter=Reporter(mission, ledger, ledger, 0.0),
        operator=ledger,
        guard=ledger,
        load=load,
    )
    return Flight(mission, gear).run(), ideal, ledger


def blind(ideal):
    ideal.blind = True


def see(ideal):
    ideal.blind, ideal._frames = False, int(ideal.time * 15) + 1


def phases(ledger):
    seen = []
    for record in ledger.of(SafetyRecord):
        if not seen or seen[-1] != record.phase:
            seen.append(record.phase)
    return seen


def path(ideal):
    return np.array([s.position_site for s in ideal.setpoints])
