"""What is wrong is seen for what it is, by small pure functions; and what follows from it."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.flight.emergency import HARD, REACTION, needed, too_near
from orchard_cli.flight.eyesight import Eyesight, Sight, worth
from orchard_cli.flight.inbox import Inbox
from orchard_cli.flight.phases import step
from orchard_cli.flight.safety import TABLE, TOLD, Hazard, Phase, Tolerances
from orchard_cli.flight.stage import Stage
from orchard_cli.flight.wind import GRAVITY, Lean
from orchard_cli.geometry.rotations import from_yaw_pitch_roll
from orchard_cli.model.depth import DepthFrame, d455
from orchard_cli.model.world import Pole, Tree, World
from orchard_cli.simulator.scene import Scene
from tests.laws.test_safety import decide, seen, vehicle

CAMERA = d455(212, 120)
FLAT = np.array([1.0, 0.0, 0.0, 0.0])
ORCHARD = World(
    "rows",
    trees=tuple(Tree(3.0 * k, y, height=3.0) for k in range(8) for y in (-3.0, 3.0)),
    poles=(Pole(4.0, 0.2, 0.1, 6.0),),
)


def image(x=0.0, y=0.0, z=2.5, yaw=0.0, number=1, world=ORCHARD):
    place, turn = np.array([x, y, z]), from_yaw_pitch_roll(yaw)
    return Scene(world).render(CAMERA, place, turn, 0.0, number)


@settings(max_examples=40, deadline=None)
@given(st.floats(0, 20), st.floats(-4, 4), st.floats(1.0, 4.0), st.floats(-3.1, 3.1))
def test_every_image_of_an_orchard_is_worth_something(x, y, z, yaw):
    depth = image(x, y, z, yaw)
    assert worth(depth) is (Sight.GOOD if depth.any() else Sight.BLANK)


@given(st.integers(0, 1000), st.sampled_from([(1, 65535), (600, 6000), (0, 65535)]))
def test_noise_is_told_from_a_scene_whatever_its_range(seed, span):
    noise = np.random.default_rng(seed).integers(*span, (120, 212)).astype(np.uint16)
    assert worth(noise) is Sight.GARBLED


def test_a_blank_image_and_one_of_a_single_depth_are_none():
    assert worth(np.zeros((120, 212), np.uint16)) is Sight.BLANK
    assert worth(np.full((120, 212), 3000, np.uint16)) is Sight.GARBLED


def test_a_few_returns_are_no_noise():
    few = np.zeros((120, 212), np.uint16)
    few[::8, :4] = np.random.default_rng(1).integers(1, 60000, (15, 4))
    assert worth(few) is Sight.GOOD


def test_a_frame_from_the_future_is_not_used_and_a_waiting_one_is_kept_a_while():
    inbox, depth = Inbox(), image()
    first, second = (DepthFrame(time, depth, CAMERA) for time in (1.0, 1.1))
    assert not inbox.put(DepthFrame(9.0, depth, CAMERA), 1.0)
    assert inbox.put(first, 1.0)
    assert inbox.put(second, 1.1)
    assert inbox.take(0.9) is None
    assert inbox.take(1.05) is first
    assert inbox.take(2.0) is None
    assert inbox.newest == 1.1


def watch(eyes, images, speed, rate=15.0):
    """Look at images while moving along x; what they are worth, and what lasts."""
    for k, depth in enumerate(images):
        time = k / rate
        state = vehicle(position_site=np.array([speed * time, 0.0, 2.5]))
        sight = eyes.look(DepthFrame(time, depth, CAMERA), state)
    return sight, eyes.ill


def test_the_same_image_again_and_again_is_frozen_only_when_the_vehicle_moves():
    depth = image()
    assert watch(Eyesight(), [depth] * 15, speed=1.0) == (Sight.FROZEN, Sight.FROZEN)
    assert watch(Eyesight(), [depth] * 150, speed=0.0) == (Sight.GOOD, Sight.GOOD)


def test_a_camera_that_sees_is_never_frozen_and_one_bad_image_is_no_illness():
    good = [image(x=k / 15, number=k) for k in range(12)]
    assert watch(Eyesight(), good, speed=1.0) == (Sight.GOOD, Sight.GOOD)
    blank = np.zeros_like(good[0])
    assert watch(Eyesight(), [*good, blank], speed=1.0) == (Sight.BLANK, Sight.GOOD)
    assert watch(Eyesight(), [*good, *[blank] * 6], speed=1.0) == (Sight.BLANK, Sight.BLANK)
    assert watch(Eyesight(), [*good, *[blank] * 6, good[0]], speed=1.0)[1] is Sight.GOOD


@given(st.floats(0.0, 5.0))
def test_hard_braking_ends_before_what_the_emergency_leaves(speed):
    """Reaction and braking together never take the airframe to what it saw."""
    travelled = speed * REACTION + speed**2 / (2 * HARD)
    assert needed(speed, 0.35) - travelled >= 0.35


@pytest.mark.parametrize(
    ("ahead", "aside", "speed", "near"),
    [
        (0.85, 0.0, 1.0, True),
        (0.85, 0.3, 1.0, True),
        (0.85, 0.7, 1.0, False),  # passes beside
        (2.5, 0.0, 1.0, False),  # far enough to be gone round
        (2.5, 0.0, 3.0, True),  # not at this speed
        (0.85, 0.0, 0.1, False),  # it stands
    ],
)
def test_only_what_is_in_the_way_nearer_than_braking_allows_is_an_emergency(
    ahead, aside, speed, near
):
    world = World("pole", poles=(Pole(ahead + 0.1, aside, 0.1, 6.0),))
    frame = DepthFrame(0.0, image(world=world), CAMERA)
    state = vehicle(
        position_site=np.array([0.0, 0.0, 2.5]), velocity_site=np.array([speed, 0.0, 0.0])
    )
    assert too_near(frame, state, 0.35) is near


def test_flying_over_the_trees_or_past_them_is_no_emergency():
    for x, yaw in itertools.product(np.arange(0.0, 20.0, 0.7), (0.0, 0.1)):
        frame = DepthFrame(0.0, image(x, 0.9 if x < 5 else 0.0, 3.6, yaw), CAMERA)
        way = np.array([math.cos(yaw), math.sin(yaw), 0.0])
        if x > 4.5 or x < 2.5:
            assert not too_near(frame, vehicle(velocity_site=way), 0.35), x


def leaning(angle, seconds, wanted=(0.0, 0.0, 0.0)):
    lean = Lean()
    for k in range(int(seconds * 50) + 2):
        turned = vehicle(time=k * 0.02, site_from_body=from_yaw_pitch_roll(0.7, angle))
        lean.after(turned, np.array(wanted))
    return lean.angle


@pytest.mark.parametrize("angle", [-0.4, -0.1, 0.02, 0.3])
def test_a_steady_lean_is_the_winds(angle):
    assert leaning(angle, 20.0) == pytest.approx(abs(angle), abs=0.01)


def test_a_gust_and_a_lean_that_was_asked_for_are_not():
    assert leaning(0.35, 0.5) < Tolerances().lean
    asked = GRAVITY * math.tan(0.35) * np.array([math.cos(0.7), math.sin(0.7), 0.0])
    assert leaning(0.35, 20.0, asked) == pytest.approx(0.0, abs=0.01)


LONG = Tolerances(empty_returns=True)
SIGNS = {
    Hazard.FRAME_BLANK: {"sight": Sight.BLANK},
    Hazard.FRAME_GARBLED: {"sight": Sight.GARBLED},
    Hazard.FRAME_FROZEN: {"sight": Sight.FROZEN},
    Hazard.GPS_LOST: {"unfixed": 3.0},
    Hazard.OBSTACLE: {"obstacle_near": True},
    Hazard.ALIVE: {"alive": True},
    Hazard.WIND: {"lean": 0.4},
    Hazard.TANK_EMPTY: {"tank_empty": True},
    Hazard.LOG_LOST: {"log_lost": True},
}


@pytest.mark.parametrize("phase", list(Phase))
@pytest.mark.parametrize("hazard", list(SIGNS))
def test_each_sign_leads_to_the_cell_of_its_hazard(phase, hazard):
    state = seen(**SIGNS[hazard])
    after = step(Stage(phase, 90.0, "test", engaged=True), state, 100.0, LONG).stage
    cell = TABLE[phase, hazard]
    if cell is not None and phase is not Phase.TAKEOFF:
        assert after.phase is cell
        assert after.why.startswith(hazard.value)
        assert after.cause is hazard
    elif phase in (Phase.ROUTE, Phase.AVOIDANCE):
        assert after.phase is Phase.ROUTE


@pytest.mark.parametrize("hazard", [h for h in SIGNS if TABLE[Phase.ROUTE, h] is Phase.HOLD])
def test_a_hold_goes_on_when_its_cause_is_over_and_ends_when_it_is_not(hazard):
    held = decide(Phase.ROUTE, **SIGNS[hazard]).stage
    still = seen(still=True, **SIGNS[hazard])
    assert step(held, still, 103.0, Tolerances()).stage.phase is Phase.HOLD
    assert step(held, seen(still=True), 103.0, Tolerances()).stage.phase is Phase.RESUME
    assert step(held, still, 131.0, Tolerances()).stage.phase is Phase.LANDING


def test_an_empty_tank_brings_it_back_only_where_that_was_chosen():
    assert decide(Phase.ROUTE, tank_empty=True).stage.phase is Phase.ROUTE
    back = step(Stage(Phase.ROUTE, 90.0, "test"), seen(tank_empty=True), 100.0, LONG).stage
    assert (back.phase, back.why) == (Phase.RETURN, "the tank is empty")


@pytest.mark.parametrize("phase", [Phase.ROUTE, Phase.RETURN, Phase.RESUME])
def test_a_log_that_loses_records_is_told_and_changes_nothing(phase):
    well, losing = decide(phase), decide(phase, log_lost=True)
    assert losing.hazards == (Hazard.LOG_LOST,)
    assert {Hazard.LOG_LOST} == TOLD
    assert replace(losing, hazards=()) == well
