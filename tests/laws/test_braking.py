"""Coming to rest: on the path, within the limit, in the room given."""

import numpy as np
import pytest

from orchard_cli.model.trajectory import Trajectory
from orchard_cli.motion.braking import brake, brake_within, first_knot

from ..pole_world import same_until, straight_route


def bend():
    """A quarter circle of 3 m radius between straights, at 1 m/s."""
    angles = np.linspace(0, np.pi / 2, 10)
    arc = np.column_stack([10 + 3 * np.sin(angles), 3 - 3 * np.cos(angles)])
    line = np.column_stack([np.arange(0, 10, 0.5), np.zeros(20)])
    out = np.column_stack([np.full(20, 13.0), 3 + np.arange(1, 21) * 0.5])
    points = np.concatenate([line, arc, out])
    return Trajectory(0.0, 0.5, np.column_stack([points, np.full(len(points), 3.5)]))


def states(trajectory, begin):
    return trajectory.sample(np.arange(begin, trajectory.end, 0.02))


@pytest.mark.parametrize("route", [straight_route(), bend()])
@pytest.mark.parametrize("start", [4.0, 8.13, 9.9, 12.6])
@pytest.mark.parametrize("deceleration", [0.5, 0.3])
def test_ends_at_rest_on_the_path_within_the_limit(route, start, deceleration):
    braked = brake(route, start, deceleration)
    same_until(route, braked, start - 1, start)
    end = braked.at(braked.end)
    assert np.linalg.norm(end.velocity_site) < 1e-9
    assert np.linalg.norm(end.acceleration_site) < 1e-9
    positions, velocities, accelerations = states(braked, start)
    _, own_velocities, own_accelerations = states(route, start)
    own = np.linalg.norm(own_accelerations, axis=1).max()  # the bend's, at full speed
    assert np.linalg.norm(accelerations, axis=1).max() < max(deceleration, own) + 0.02
    assert (
        np.linalg.norm(velocities, axis=1).max()
        < np.linalg.norm(own_velocities, axis=1).max() + 0.01
    )
    path = route.sample(np.arange(0, route.end, 0.01))[0]
    off = [np.linalg.norm(path - p, axis=1).min() for p in positions]
    assert max(off) < 0.06


def test_full_braking_from_1_m_s_takes_no_more_than_a_step_over_the_ideal():
    """v²/2a is 1 m; the spline's first free control point costs up to one interval more."""
    route = straight_route()
    braked = brake(route, 20.0, 0.5)
    run = np.linalg.norm(braked.at(braked.end).position_site - route.at(20.0).position_site)
    assert 1.0 <= run <= 1.6


@pytest.mark.parametrize("room", [1.4, 2.0, 3.3, 6.0])
def test_uses_the_room_and_not_more(room):
    route = straight_route()
    done = brake_within(route, 20.0, room, 0.3, 0.5)
    assert done.fits
    run = np.linalg.norm(done.trajectory.at(1e9).position_site - route.at(20.0).position_site)
    assert run <= room + 1e-6
    assert run > room - 1.0


def test_too_little_room_is_said_and_braked_as_hard_as_allowed():
    route = straight_route()
    done = brake_within(route, 20.0, 0.5, 0.3, 0.5)
    assert not done.fits
    hardest = brake(route, 20.0, 0.5)
    np.testing.assert_array_equal(done.trajectory.control_points_site, hardest.control_points_site)


def test_what_comes_to_rest_sooner_is_left_alone():
    route = straight_route()
    assert brake(route, route.end - 0.3, 0.3) is route
    assert brake_within(route, 20.0, 1000.0, 0.3, 0.5).trajectory is route


def test_first_knot_is_the_first_that_may_change():
    route = straight_route()
    assert first_knot(route, 1.0) == 2
    assert first_knot(route, 1.01) == 3
    assert first_knot(route, -5.0) == 0
    assert first_knot(route, 1e9) == len(route.control_points_site) - 3
