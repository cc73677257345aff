"""What `guided` promises, flown with perfect tracking past poles that a camera discovers.

Clearances are from the airframe's centre to the pole's true surface.
"""

import numpy as np
import pytest

from orchard_cli.avoidance import Guided, GuidedSettings
from orchard_cli.model.mission import Limits
from orchard_cli.motion.fit import rounded
from orchard_cli.motion.situation import Avoid, Keep, Stop
from orchard_cli.motion.splice import shared_tail
from orchard_cli.motion.subdivision import refined
from orchard_cli.motion.timing import PathLimits, time_path

from ..pole_world import CELL, LOWER, PoleMap, avoids, fly, situation, straight_route

LIMITS = Limits()
ROUTE = straight_route(40.0)


def past(poles, route=ROUTE, **kwargs):
    return fly(Guided(), route, PoleMap(poles), **kwargs)


@pytest.mark.parametrize("offset", [0.0, 0.1, -0.35, 0.8])
def test_a_pole_is_passed_clear_gently_and_back_on_the_line(offset):
    poles = [(20.0, offset, 0.15)]
    flight = past(poles)
    assert flight.clearance(poles) >= LIMITS.clearance
    assert np.abs(flight.positions[:, 1]).max() <= 1.4
    cruising = (flight.positions[:, 0] > 4) & (flight.positions[:, 0] < 36)
    assert flight.accelerations[cruising].max() <= 0.3
    assert flight.speeds.max() <= 1.03
    assert flight.speeds[cruising].min() > 0.8
    assert flight.kinds() == ["Avoid"]
    behind = flight.positions[flight.positions[:, 0] > 27]
    assert np.abs(behind[:, 1]).max() < 0.01
    np.testing.assert_allclose(flight.positions[:, 2], 3.5, atol=1e-9)
    assert flight.last.end - ROUTE.end <= 1.0


def test_close_to_but_not_on_the_line_counts():
    """PEERS: checks being inside an obstacle but not close to one."""
    poles = [(20.0, 0.95, 0.15)]
    flight = past(poles)
    assert flight.kinds() == ["Avoid"]
    assert flight.positions[:, 1].min() < -0.1
    assert flight.clearance(poles) >= LIMITS.clearance


def test_goes_round_the_nearer_side():
    assert past([(20.0, 0.4, 0.15)]).positions[:, 1].min() < -0.5
    assert past([(20.0, -0.4, 0.15)]).positions[:, 1].max() > 0.5


def test_two_poles_8_m_apart_as_in_row_6():
    poles = [(15.0, 0.0, 0.15), (23.0, 0.0, 0.15)]
    flight = past(poles)
    assert flight.clearance(poles) >= LIMITS.clearance
    assert np.abs(flight.positions[:, 1]).max() <= 1.6
    assert len(avoids(flight)) == 2
    assert flight.accelerations.max() <= LIMITS.acceleration * 1.01


def test_never_flips_between_two_ways_round():
    """PEERS: flips for ever between two ways round. The pole's edges flicker by a cell."""
    poles = [(20.0, 0.0, 0.15)]
    rng = np.random.default_rng(4)

    def flicker(now, grid):
        seen = np.argwhere(grid.occupied)
        if len(seen):
            i, j = seen[rng.integers(len(seen))] + rng.integers(-1, 2, 2)
            grid.occupied[i, j] = now % 0.2 < 0.1 or grid.occupied[i, j]

    flight = past(poles, each=flicker)
    side = [np.sign(a.trajectory.at(21.0).position_site[1]) for a in avoids(flight)]
    assert len(set(side)) == 1
    assert len(side) <= 4
    assert flight.clearance(poles) >= LIMITS.clearance


@pytest.mark.parametrize("seed", range(6))
def test_random_pole_fields_are_flown_clear_within_the_limits(seed):
    rng = np.random.default_rng(seed)
    n = rng.poisson(0.03 * 32 * 10)
    poles = np.column_stack([rng.uniform(6, 36, n), rng.uniform(-5, 5, n), np.full(n, 0.15)])
    flight = past(poles)
    assert flight.clearance(poles) >= LIMITS.clearance
    assert flight.accelerations.max() <= LIMITS.acceleration * 1.01
    assert flight.speeds.max() <= LIMITS.speed * 1.03
    assert np.linalg.norm(flight.positions[-1] - ROUTE.at(ROUTE.end).position_site) < 0.01


def test_a_fence_of_poles_is_stopped_before_and_passed_when_it_opens():
    """PEERS: stops at speed without braking; in obstacle until restart."""
    poles = [(20.0, y, 0.15) for y in np.arange(-12, 12.1, 0.8)]

    def open_up(now, grid):
        if now > 28.0:
            grid.poles = grid.poles[:0]
            grid.occupied[:] = False

    flight = past(poles, each=open_up, longest=80.0)
    assert "Stop" in flight.kinds()
    assert flight.accelerations.max() <= LIMITS.acceleration * 1.01
    standing = flight.positions[flight.speeds < 1e-6]
    waited = standing[(standing[:, 0] > 1) & (standing[:, 0] < 30)]
    assert 20 - 0.15 - waited[:, 0].max() >= LIMITS.clearance
    resumed = avoids(flight)[-1]
    assert resumed.why == "resuming"
    assert np.linalg.norm(flight.positions[-1] - ROUTE.at(ROUTE.end).position_site) < 0.01


def test_a_goal_inside_an_obstacle_is_stopped_before():
    poles = [(40.0, 0.0, 0.3)]
    flight = past(poles, longest=60.0)
    assert flight.kinds()[-1] in ("Stop", "Keep")
    assert flight.clearance(poles) >= LIMITS.clearance
    assert flight.speeds[-1] < 1e-6


@pytest.mark.parametrize("speed", [0.4, 0.8, 1.0])
@pytest.mark.parametrize("ahead", [1.8, 2.2, 3.0])
def test_late_discoveries_end_in_a_detour_or_in_the_hardest_braking_allowed(speed, ahead):
    route = straight_route(40.0, speed=speed, interval=0.5 / speed)
    now = 15.0 / speed
    here = route.at(now).position_site
    pole = (here[0] + ahead, here[1] + 0.1, 0.15)
    grid = PoleMap([pole], known=True)
    verdict = Guided().plan(situation(now, now, route, route, grid))
    assert isinstance(verdict, Avoid | Stop)
    times = np.arange(now, verdict.trajectory.end, 0.05)
    positions, _, accelerations = verdict.trajectory.sample(times)
    away = (np.hypot(*(positions[:, :2] - pole[:2]).T) - pole[2]).min()
    assert np.linalg.norm(accelerations, axis=1).max() <= LIMITS.acceleration * 1.01
    if isinstance(verdict, Avoid) or "full braking" not in verdict.why:
        assert away >= LIMITS.clearance


def test_the_detour_ends_in_the_reference_a_whole_number_of_fine_intervals_later():
    now = 15.0
    grid = PoleMap([(20.0, 0.0, 0.15)], known=True)
    verdict = Guided().plan(situation(now, now + 0.2, ROUTE, ROUTE, grid))
    assert isinstance(verdict, Avoid)
    delay = verdict.trajectory.end - ROUTE.end
    fine = refined(ROUTE, GuidedSettings().halvings)
    assert delay / fine.interval == pytest.approx(round(delay / fine.interval))
    for t in np.linspace(verdict.rejoin, verdict.trajectory.end, 7):
        there, here = verdict.trajectory.at(t), ROUTE.at(t - delay)
        np.testing.assert_allclose(there.position_site, here.position_site, atol=1e-9)
    assert shared_tail(verdict.trajectory, fine) > 80
    assert verdict.begin >= now + 0.2
    assert {"check", "search", "optimise", "replan"} <= set(verdict.stages_ms)
    assert len(verdict.guide_site) > 1


def test_keeps_the_detour_while_it_stays_free():
    now = 15.0
    grid = PoleMap([(20.0, 0.0, 0.15)], known=True)
    system = Guided()
    first = system.plan(situation(now, now + 0.2, ROUTE, ROUTE, grid))
    for later in np.arange(now + 0.07, 30.0, 0.5):
        again = system.plan(situation(later, later + 0.2, first.trajectory, ROUTE, grid))
        assert isinstance(again, Keep)


def test_height_of_the_reference_is_kept_where_it_climbs():
    control = straight_route(40.0).control_points_site.copy()
    control[:, 2] += 0.02 * control[:, 0]
    route = type(ROUTE)(0.0, 0.5, control)
    flight = past([(20.0, 0.0, 0.15)], route=route)
    assert flight.kinds() == ["Avoid"]
    expected = 3.5 + 0.02 * flight.positions[:, 0]
    assert np.abs(flight.positions[:, 2] - expected).max() < 0.03


def test_never_flies_where_the_camera_has_not_looked():
    grid = PoleMap([])
    grid.observed[round((18.0 - LOWER) / CELL) :] = False
    now = 18.6
    ahead = Guided().plan(situation(now, now + 0.2, ROUTE, ROUTE, grid))
    assert isinstance(ahead, Keep)  # the camera looks there now
    aside = Guided().plan(situation(now, now + 0.2, ROUTE, ROUTE, grid, yaw=1.6))
    assert isinstance(aside, Stop)
    halt = aside.trajectory.at(aside.trajectory.end)
    assert halt.position_site[0] - ROUTE.at(now).position_site[0] < 2.2
    assert np.linalg.norm(halt.velocity_site) < 1e-9


def test_a_pole_seen_late_is_braked_before_and_passed_slowly():
    """One trajectory: it slows down along the route, and goes round at a crawl."""
    now = 15.0
    here = ROUTE.at(now).position_site
    pole = (here[0] + 2.7, 0.05, 0.15)
    grid = PoleMap([pole], known=True)
    verdict = Guided().plan(situation(now, now + 0.2, ROUTE, ROUTE, grid))
    assert isinstance(verdict, Avoid)
    positions, velocities, accelerations = verdict.trajectory.sample(
        np.arange(now, verdict.rejoin, 0.02)
    )
    assert (np.hypot(*(positions[:, :2] - pole[:2]).T) - pole[2]).min() >= LIMITS.clearance
    assert np.linalg.norm(accelerations, axis=1).max() <= LIMITS.acceleration * 1.01
    assert np.linalg.norm(velocities, axis=1).min() < 0.6


@pytest.mark.parametrize("before_the_end", [3.0, 5.0])
def test_a_pole_in_a_short_row_does_not_cost_the_waypoint_behind_it(before_the_end):
    corner = np.array([16.0, 0.0, 3.5])
    path = rounded(np.array([[0, 0, 3.5], corner, [16, 6, 3.5], [0, 6, 3.5]]), 0.5)
    route = time_path(path.points_site, PathLimits.planned(LIMITS)).trajectory
    poles = [(16.0 - before_the_end - 1.0, 0.0, 0.15)]
    flight = past(poles, route=route)
    assert flight.clearance(poles) >= LIMITS.clearance
    assert np.linalg.norm(flight.positions - corner, axis=1).min() < 0.8


def test_a_pole_in_the_corner_is_gone_round_and_the_corner_said_to_be_left_out():
    path = rounded(np.array([[0, 0, 3.5], [16, 0, 3.5], [16, 14, 3.5]]), 0.5)
    route = time_path(path.points_site, PathLimits.planned(LIMITS)).trajectory
    poles = [(15.7, 0.3, 0.15)]
    flight = past(poles, route=route)
    assert flight.clearance(poles) >= LIMITS.clearance
    assert any("leaves out a corner" in a.why for a in avoids(flight))
