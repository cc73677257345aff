"""A vehicle with a tank: Ahmed 2022, eqs. 1-19, and what the flight makes of it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchard_cli.flight.gauge import Gauge
from orchard_cli.flight.safety import Phase
from orchard_cli.flight.spray import spray
from orchard_cli.model.mission import Limits
from orchard_cli.model.site import HeightReference, SiteOrigin
from orchard_cli.model.tank import GRAVITY, SPRAYER, Load
from orchard_cli.model.vehicle import Command
from orchard_cli.model.world import SensorNoise, World
from orchard_cli.simulator import LockstepSimulator, SimulatorSettings
from orchard_cli.simulator.fleet import kit

levels = st.floats(0.0, 1.0)
ORIGIN = SiteOrigin(41.0, 9.0, 0.0, HeightReference.AMSL, 0.0)
QUIET = World("quiet", noise=SensorNoise(position=0, height=0, velocity=0, attitude=0))


def blocks(level, slices=200):
    """The liquid as thin slices (mass, height under the frame's centre): an independent model."""
    floor = SPRAYER.tank_below + SPRAYER.tank[2] / 2
    depth = SPRAYER.tank[2] * level
    centres = floor - depth * (np.arange(slices) + 0.5) / slices
    return np.full(slices, 32.0 * level / slices), centres


@given(levels)
def test_mass_centre_and_inertia_are_those_of_the_liquid_slice_by_slice(level):
    masses, below = blocks(level)
    total = SPRAYER.mass + masses.sum()
    centre = (masses * below).sum() / total
    assert SPRAYER.mass_at(level) == pytest.approx(total)
    assert SPRAYER.centre_below(level) == pytest.approx(centre, abs=1e-9)
    plate = masses * 0.4**2 / 12  # of each slice about its own middle
    about_x = 0.3933 + SPRAYER.mass * centre**2 + (plate + masses * (below - centre) ** 2).sum()
    assert SPRAYER.inertia_at(level)[0] == pytest.approx(about_x, rel=1e-4)
    assert SPRAYER.inertia_at(level)[2] == pytest.approx(0.76 + 2 * plate.sum())


@given(levels, levels)
def test_more_liquid_allows_less(a, b):
    low, high = sorted((a, b))
    assert SPRAYER.acceleration_max(high) <= SPRAYER.acceleration_max(low)
    assert SPRAYER.slowdown(3.0, high) >= SPRAYER.slowdown(3.0, low)
    limits = Limits(acceleration=3.0, acceleration_along=2.0)
    heavy, light = Load(SPRAYER, high).limits(limits), Load(SPRAYER, low).limits(limits)
    assert heavy.acceleration <= light.acceleration <= 3.0
    assert heavy.acceleration_along <= heavy.acceleration


@given(levels)
def test_at_the_greatest_tilt_it_still_carries_its_weight(level):
    lift = SPRAYER.thrust_max * math.cos(SPRAYER.tilt_max(level))
    assert lift >= SPRAYER.mass_at(level) * GRAVITY * (1 - 1e-12)
    speed = 3.5
    stop = speed**2 / (2 * SPRAYER.acceleration_max(level))
    assert SPRAYER.slowdown(speed, level) == pytest.approx(stop)


def test_the_limits_never_grow_with_a_load():
    limits = Load(SPRAYER, 0.0).limits(Limits())
    assert limits.acceleration == 0.5
    assert limits.airframe_radius == SPRAYER.radius
    assert limits.clearance == 1.0


def test_the_gauge_counts_what_the_pump_takes_and_switches_it_on_changes_only():
    switched = []
    gauge = Gauge(Load(SPRAYER, 0.5), switched.append)
    for k in range(601):
        gauge.run(100 <= k < 400, k * 0.1)
    assert switched == [True, False]
    assert gauge.used == pytest.approx(2.0 * 30 / 60, rel=0.01)
    assert gauge.load.level == pytest.approx(0.5 - 1.0 / 32, rel=0.01)


def test_no_tank_no_pump():
    gauge = Gauge(None, lambda on: pytest.fail("there is no pump"))
    gauge.run(True, 1.0)
    assert (gauge.used, gauge.empty) == (None, False)


def test_the_gauge_stops_at_empty_and_nothing_is_sprayed_then():
    gauge = Gauge(Load(SPRAYER, 0.001), lambda on: None)
    for k in range(100):
        gauge.run(True, k * 0.1)
    assert gauge.empty
    assert gauge.used == pytest.approx(0.032)
    said = spray(None, Phase.ROUTE, None, empty=True)
    assert (said.on, said.why) == (False, "the tank is empty")


@pytest.mark.parametrize("level", [0.0, 0.5, 1.0])
def test_the_sprayer_takes_off_and_hovers_with_any_load(level):
    settings = SimulatorSettings(camera=None, kit=kit("sprayer", level))
    sim = LockstepSimulator(QUIET, ORIGIN, (0.0, 0.0), 0.0, settings)
    sim.clock.sleep_until(4.0)
    sim.vehicle.command(Command.ARM)
    sim.vehicle.command(Command.TAKEOFF, 3.0)
    sim.clock.sleep_until(20.0)
    state = sim.vehicle.state()
    assert state.position_site == pytest.approx([0, 0, 3.0], abs=0.1)
    assert np.abs(state.angular_velocity_body).max() < 0.02


def test_the_simulated_tank_runs_dry_like_the_gauge_says():
    settings = SimulatorSettings(camera=None, kit=kit("sprayer", 0.01))
    sim = LockstepSimulator(QUIET, ORIGIN, (0.0, 0.0), 0.0, settings)
    body = sim._run.autopilot.craft.body
    heavy = body.load[0]
    sim.vehicle.pump(True)
    sim.clock.sleep_until(5.0)
    used = SPRAYER.flow / 60 * 5.0
    assert heavy - body.load[0] == pytest.approx(used, rel=0.01)
    sim.vehicle.pump(False)
    level = body.level
    sim.clock.sleep_until(6.0)
    assert body.level == level
    sim.vehicle.pump(True)
    sim.clock.sleep_until(20.0)
    assert (body.level, body.load[0]) == (0.0, SPRAYER.mass)


@pytest.mark.parametrize(("vehicle", "level"), [("x500", 0.0), ("sprayer", 0.0), ("sprayer", 1.0)])
def test_the_simulated_battery_hovers_as_long_as_the_mission_counts_on(vehicle, level):
    """A mission planned for 900 s must not end by a battery of 600 s."""
    flown = kit(vehicle, level)
    mass = float(flown.airframe.load(level)[0])
    power = (mass / flown.airframe.mass) ** 1.5  # of hovering empty, in still air
    assert flown.pack_for(900.0).endurance / power == pytest.approx(900.0)
    assert flown.pack_for(900.0).capacity == flown.pack.capacity
