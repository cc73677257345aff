"""The whole loop on an ideal vehicle: plan in, landing out, with and without faults."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from orchard_cli.avoidance import Blind
from orchard_cli.flight.boundary import area_of
from orchard_cli.flight.safety import Phase, Request
from orchard_cli.flight.spray import SPEED_TOLERANCE, SprayLines, spray
from orchard_cli.geometry.clearance import clearance
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.records import (
    LogLine,
    PlannerRecord,
    Severity,
    SprayRecord,
)
from orchard_cli.model.tank import SPRAYER, Load
from orchard_cli.model.vehicle import Command, FlightMode, Landed, VehicleState
from orchard_cli.model.world import Pole
from tests.loop import HEIGHT, blind, fly, path, phases, see, world_of


def test_a_free_route_is_flown_to_its_end_and_landed(mission):
    ending, ideal, ledger = fly(mission, world_of(mission))
    assert ending.as_planned, ending
    assert phases(ledger) == ["preflight", "take-off", "resume", "route", "landing", "ended"]
    assert ideal.position[:2] == pytest.approx(mission.landing_site, abs=0.01)
    sprayed = {r.row for r in ledger.of(SprayRecord) if r.on}
    assert sprayed == {0, 1}
    assert [r.text for r in ledger.of(LogLine) if r.severity is Severity.ERROR] == []


class Told(Blind):
    """Remembers by which load and limits it was to plan."""

    def __init__(self):
        self.loads, self.limits = [], []

    def plan(self, situation):
        self.loads.append(situation.load)
        self.limits.append(situation.limits)
        return super().plan(situation)


def test_the_level_lowers_with_the_flow_and_an_empty_tank_ends_the_spraying_alone(mission):
    full = Load(SPRAYER, 0.016)  # 0.51 l, 15 s of pumping: less than the two rows take
    system = Told()
    ending, ideal, ledger = fly(mission, world_of(mission), system=system, load=full)
    assert ending.as_planned, ending
    records = ledger.of(SprayRecord)
    pumped = sum(
        after.time - before.time for before, after in itertools.pairwise(records) if before.on
    )
    assert records[-1].level == 0.0
    assert records[-1].used == pytest.approx(SPRAYER.litres(full.level))
    assert pumped == pytest.approx(records[-1].used / (SPRAYER.flow / 60), abs=0.3)
    levels = [record.level for record in records]
    assert all(b <= a for a, b in itertools.pairwise(levels))
    dry = next(record.time for record in records if record.level == 0.0)
    said = [record for record in records if record.time > dry + 0.1 and "on the row" in record.why]
    assert not said
    assert any(record.why == "the tank is empty" for record in records)
    assert [on for _, on in ideal.pumped][-1] is False
    assert all(time <= dry + 0.1 for time, on in ideal.pumped if on)
    # every system is told its limits for the load of that moment: this is where they come from
    assert system.loads[0].level > system.loads[-1].level == 0.0
    for load, limits in zip(system.loads[::50], system.limits[::50], strict=True):
        assert limits == load.limits(mission.limits)


def test_a_fuller_tank_leaves_every_system_less_acceleration(mission):
    hasty = replace(mission.limits, acceleration=3.0)
    empty, full = (Load(SPRAYER, level).limits(hasty) for level in (0.0, 1.0))
    assert full.acceleration == pytest.approx(SPRAYER.acceleration_max(1.0))
    assert full.acceleration < 1.1
    assert empty.acceleration == 3.0
    assert empty.airframe_radius == full.airframe_radius == SPRAYER.radius


@pytest.mark.parametrize("share", [0.7, 0.8, 1.0, 1.2, 1.3])
def test_the_pump_runs_round_the_planned_speed_and_no_further_above_than_below(mission, share):
    segment, line = mission.spray_lines[0]
    along = (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])
    planned = mission.planned_speed(segment)
    assert planned < mission.limits.speed  # what the flight keeps in hand
    where = (line[0] + line[1]) / 2
    nose = np.array([1.0, 0.0, 0.0, 0.0])
    state = VehicleState(
        1.0, where, share * planned * along, nose, np.zeros(3),
        True, FlightMode.OFFBOARD, Landed.IN_AIR, 1.0, 1.0, 16.0, True,
    )  # fmt: skip
    said = spray(SprayLines.of(mission), Phase.ROUTE, state)
    assert said.on is (abs(share - 1) < SPEED_TOLERANCE)


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
    ending, ideal, ledger = fly(mission, world_of(mission), events=[(30.0, blind), (36.0, see)])
    assert ending.as_planned, ending
    assert phases(ledger)[3:7] == ["route", "hold", "resume", "route"]
    steps = np.linalg.norm(np.diff(path(ideal), axis=0), axis=1)
    assert steps.max() < 1.05 * mission.limits.speed * 0.02
    assert {r.row for r in ledger.of(SprayRecord) if r.on} == {0, 1}


def test_a_camera_that_never_comes_back_ends_in_a_landing(mission):
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
    ("request_", "end"), [(Request.RETURN, "return"), (Request.LAND, "diverting")]
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


POLE = (Pole(7.5, 0.0, 0.15, 8.0),)


def test_a_vehicle_that_somebody_already_flies_is_left_alone(mission):
    def airborne(ideal):
        ideal.armed, ideal.mode = True, FlightMode.PILOT

    ending, ideal, _ = fly(mission, world_of(mission), prepare=airborne)
    assert ending.trouble
    assert "already armed" in ending.why
    assert ideal.asked == []
    assert ideal.setpoints == []


@pytest.mark.parametrize("latency", [0.2, 0.34, 0.42, 0.6])
def test_a_planner_however_slow_never_leads_into_the_pole(mission, latency):
    world = world_of(mission, POLE)
    _, ideal, ledger = fly(mission, world, latency=latency)
    flown = np.array([record.position_site for record in ledger.of(VehicleState)])
    assert clearance(world, flown).obstacles.min() >= mission.limits.airframe_radius
    assert (latency < 0.3) == bool(ideal.setpoints)  # too slow to be flown with at all


@pytest.mark.parametrize("delay", [0.05, 0.1, 0.2])
def test_frames_wait_for_the_poses_of_a_slow_link(mission, delay):
    world = world_of(mission, POLE)

    def slow(ideal):
        ideal.pose_delay = delay

    ending, ideal, _ = fly(mission, world, prepare=slow)
    assert clearance(world, path(ideal)).obstacles.min() >= mission.limits.clearance
    assert ending.as_planned, ending


def test_frames_from_the_future_are_as_good_as_none(mission):
    def stamped_ahead(ideal):
        take = ideal.latest

        def latest():
            frame = take()
            return frame and DepthFrame(frame.time + 1000.0, frame.depth_mm, frame.camera)

        ideal.latest = latest

    ending, ideal, _ = fly(mission, world_of(mission), prepare=stamped_ahead)
    assert ending.trouble
    assert "no fresh depth frames" in ending.why
    assert ideal.asked == []


@pytest.mark.parametrize("gap", [0.3, 0.6, 0.75, 1.5])
def test_after_a_gap_in_the_telemetry_the_rest_of_the_route_is_flown(mission, gap):
    def cut(ideal):
        ideal.deaf = True

    def mend(ideal):
        ideal.deaf = False

    ending, ideal, _ = fly(mission, world_of(mission), events=[(30.0, cut), (30.0 + gap, mend)])
    assert ending.as_planned, ending
    assert ideal.position[:2] == pytest.approx(mission.landing_site, abs=0.01)


def test_an_obstacle_between_the_vehicle_and_the_routes_start_is_seen(mission):
    x, y = mission.takeoff_site
    world = world_of(mission, (Pole(float(x), float(y) + 2.2, 0.15, 8.0),))

    def aside(ideal):
        ideal.position = np.array([float(x), float(y) + 4.5, 0.0])

    _, ideal, _ = fly(mission, world, prepare=aside)
    assert clearance(world, path(ideal)).obstacles.min() >= mission.limits.airframe_radius


def test_a_ground_station_that_takes_over_in_a_return_is_not_fought(mission):
    def take_over(ideal):
        ideal.mode = FlightMode.HOLD
        ideal.taken = len(ideal.asked)

    def disarm(ideal):
        ideal.armed = False

    _, ideal, ledger = fly(
        mission,
        world_of(mission),
        requests=[(30.0, Request.RETURN)],
        events=[(45.0, take_over), (60.0, disarm)],
    )
    assert phases(ledger)[-2:] == ["pilot", "ended"]
    assert ideal.asked[ideal.taken :] == []


def test_a_hold_that_the_operator_asks_for_stays_one_though_the_camera_comes_back(mission):
    _, _, ledger = fly(
        mission,
        world_of(mission),
        events=[(30.0, blind), (36.0, see)],
        requests=[(33.0, Request.HOLD), (60.0, Request.LAND)],
    )
    assert phases(ledger)[4:] == ["hold", "diverting", "landing", "ended"]


def test_a_camera_that_comes_and_goes_for_ever_does_not_hold_for_ever(mission):
    def flicker(ideal):
        ideal.blind = not ideal.blind
        if not ideal.blind:
            ideal._frames = int(ideal.time * 15) + 1
        ideal.events.append((ideal.time + (0.75 if ideal.blind else 2.6), flicker))

    ending, ideal, _ = fly(mission, world_of(mission), events=[(30.0, flicker)])
    assert ideal.time < 400.0
    assert ideal.battery > 0.3
    del ending


def test_held_on_the_way_home_it_goes_on_home_and_not_out_again(mission):
    _, ideal, ledger = fly(
        mission,
        world_of(mission),
        requests=[(32.0, Request.RETURN)],
        events=[(51.0, blind), (54.0, see)],
    )
    assert phases(ledger)[-4:] == ["hold", "return", "landing", "ended"]
    times = np.array([s.time for s in ideal.setpoints])
    travelled = np.concatenate(
        [[0.0], np.cumsum(np.linalg.norm(np.diff(path(ideal), axis=0), axis=1))]
    )
    out, back, rest = np.diff(np.interp([0.0, 36.0, 54.0, 1e3], times, travelled))
    assert back > 5.0
    assert rest <= out - back + 2.0


def test_a_throwing_planner_ends_in_a_landing(mission):
    class Broken:
        name = "broken"

        def plan(self, situation):
            raise RuntimeError("no")

    ending, _, ledger = fly(mission, world_of(mission), system=Broken())
    assert not ending.as_planned
    assert "landing" in phases(ledger)


def test_asking_to_land_while_it_arms_disarms_it(mission):
    _, ideal, _ = fly(
        mission,
        world_of(mission),
        requests=[(0.07, Request.LAND)],
    )
    assert ideal.asked[-1] in (Command.DISARM, Command.LAND)


def test_a_reset_of_the_estimator_holds_and_the_route_goes_on_where_it_was(mission):
    def reset(ideal):
        ideal.offset = np.array([2.0, -1.5, 0.4])
        stale = ideal.setpoint  # a real vehicle does not get there within a cycle
        ideal.setpoint = replace(stale, position_site=stale.position_site + ideal.offset)

    ending, ideal, ledger = fly(mission, world_of(mission), events=[(30.0, reset)])
    assert ending.as_planned, ending
    assert phases(ledger)[3:7] == ["route", "hold", "resume", "route"]
    assert ideal.position[:2] == pytest.approx(mission.landing_site, abs=0.05)  # where it was
    said = [record.text for record in ledger.of(LogLine)]
    assert any("the position estimate jumped by (+2" in text for text in said)


def test_a_way_round_through_a_keep_out_is_refused_and_the_vehicle_goes_home(mission):
    def beside(y):
        return np.array([[6.0, y], [9.0, y], [9.0, y + 3.0], [6.0, y + 3.0]])

    closed = replace(mission.orchard, keep_outs_site=(beside(0.5), beside(-3.5)))
    fenced = replace(mission, orchard=closed)
    ending, ideal, ledger = fly(fenced, world_of(mission, POLE))
    assert not ending.as_planned
    assert phases(ledger)[-4:] == ["hold", "return", "landing", "ended"]
    decided = [r.why for r in ledger.of(PlannerRecord) if r.decision == "stop"]
    assert any("leave the fence or enter a keep-out" in why for why in decided)
    assert area_of(fenced).margins(path(ideal)).min() >= 0.0
