"""The rigid body against an independent integration and the laws of mechanics."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from orchard_cli.simulator.body import X500, Body

DT = 0.002
G = 9.80665
HOVER = np.full(4, X500.hover_speed)
# Of each rotor: place in units of the arm (x forward, y left), and sense (+1 counter-clockwise).
ROTORS = ((1, -1, 1), (-1, 1, 1), (1, 1, -1), (-1, -1, -1))


def flying(height: float = 50.0) -> Body:
    body = Body(X500, (0.0, 0.0), 0.0)
    body.state[2] = height
    body.state[13:17] = X500.hover_speed
    return body


def fly(body: Body, speeds: np.ndarray, seconds: float) -> None:
    for _ in range(round(seconds / DT)):
        body.step(speeds, DT)


def independent(
    state: np.ndarray, speeds: np.ndarray, wind: np.ndarray, load: np.ndarray, seconds: float
) -> np.ndarray:
    """Newton and Euler with rotation matrices of scipy, integrated by DOP853."""
    inertia = np.diag(load[1:4])

    def slope(_: float, y: np.ndarray) -> np.ndarray:
        velocity, q, rates, rotors = y[3:6], y[6:10], y[10:13], y[13:17]
        turn = Rotation.from_quat(q, scalar_first=True).as_matrix()
        force_body, torque = np.zeros(3), np.zeros(3)
        air_body = turn.T @ (velocity - wind)
        for (x, y_, sense), speed in zip(ROTORS, rotors, strict=True):
            thrust = np.array([0.0, 0.0, X500.thrust * speed**2])
            drag = -X500.drag_rotor * speed * air_body * (1, 1, 0)
            force_body += thrust + drag
            torque += np.cross(X500.arm * np.array([x, y_, 0.0]), thrust)
            torque += np.cross([0.0, 0.0, load[4]], drag)  # rotors over the centre of mass
            torque[2] -= sense * X500.moment * thrust[2]
        relative = velocity - wind
        force = turn @ force_body - X500.drag_body * np.linalg.norm(relative) * relative
        w, v = q[0], q[1:]
        return np.concatenate(
            [
                velocity,
                force / load[0] - [0, 0, G],
                [-0.5 * v @ rates],
                0.5 * (w * rates + np.cross(v, rates)),
                np.linalg.solve(inertia, torque - np.cross(rates, inertia @ rates)),
                (speeds - rotors) / X500.lag,
            ]
        )

    result = solve_ivp(slope, (0, seconds), state, "DOP853", rtol=1e-11, atol=1e-12)
    return np.asarray(result.y[:, -1])


def test_it_agrees_with_an_independent_integration_after_two_seconds() -> None:
    body = flying()
    body.state[3:6] = (1.0, -2.0, 0.5)
    body.state[6:10] = Rotation.from_euler("xyz", [0.2, -0.3, 1.0]).as_quat(scalar_first=True)
    body.state[10:13] = (0.4, -0.3, 0.8)
    body.load[:] = (2.6, 0.03, 0.025, 0.05, 0.2)  # a tank aboard
    wind = np.array([2.0, 1.0, -0.3])
    body.around[:3] = wind
    speeds = X500.hover_speed * np.array([1.02, 1.03, 1.025, 1.021])
    truth = independent(body.state.copy(), speeds, wind, body.load, 2.0)
    fly(body, speeds, 2.0)
    assert np.abs(body.position_site - truth[:3]).max() < 1e-6
    assert np.abs(body.velocity_site - truth[3:6]).max() < 1e-6
    assert np.abs(body.site_from_body - truth[6:10]).max() < 1e-6
    assert np.abs(body.rates_body - truth[10:13]).max() < 1e-6


def test_the_step_is_of_fourth_order() -> None:
    def error(dt: float) -> float:
        body = flying()
        body.state[3:6] = (3.0, 1.0, 0.0)
        body.state[10:13] = (1.0, 2.0, -1.5)
        truth = independent(body.state.copy(), HOVER * 1.1, np.zeros(3), body.load, 0.4)
        for _ in range(round(0.4 / dt)):
            body.step(HOVER * 1.1, dt)
        return float(np.abs(body.state[:13] - truth[:13]).max())

    assert error(0.008) / error(0.004) == pytest.approx(16, rel=0.3)


def test_hover_speed_holds_it_in_still_air() -> None:
    body = flying()
    fly(body, HOVER, 5.0)
    assert np.abs(body.position_site - (0, 0, 50)).max() < 1e-9


def test_without_rotors_it_falls_freely() -> None:
    body = flying(1000.0)
    body.state[13:17] = 0.0
    fly(body, np.zeros(4), 0.5)
    assert body.velocity_site[2] == pytest.approx(-G * 0.5, rel=0.01)  # little drag yet
    fly(body, np.zeros(4), 12.0)
    terminal = math.sqrt(X500.mass * G / X500.drag_body)
    assert -terminal < body.velocity_site[2] < -0.95 * terminal


def test_with_broken_rotors_it_falls_and_comes_to_lie_whatever_they_are_told() -> None:
    body = flying(3.5)
    body.state[3:6] = (1.0, 0.0, 0.0)
    body.state[6:10] = Rotation.from_euler("xy", [0.2, -0.1]).as_quat(scalar_first=True)
    body.break_rotors()
    fly(body, np.full(4, X500.speed_max), 0.5)
    assert body.velocity_site[2] == pytest.approx(-G * 0.5, rel=0.02)  # a little drag
    assert body.rates_body == pytest.approx(np.zeros(3), abs=1e-9)
    assert body.airborne
    fly(body, np.full(4, X500.speed_max), 4.0)
    assert not body.airborne
    assert np.abs(body.velocity_site).max() < 1e-3
    assert body.position_site[2] == pytest.approx(0.0, abs=0.01)


def test_angular_momentum_is_kept_while_it_tumbles_without_rotors() -> None:
    body = flying(1000.0)
    body.state[13:17] = 0.0
    body.state[10:13] = (3.0, 4.0, 2.0)

    def momentum() -> np.ndarray:
        turn = Rotation.from_quat(body.site_from_body, scalar_first=True)
        return np.asarray(turn.apply(body.load[1:4] * body.rates_body))

    before = momentum()
    fly(body, np.zeros(4), 2.0)
    assert momentum() == pytest.approx(before, abs=1e-7)


@pytest.mark.parametrize(
    ("faster", "axis", "sense"),
    [
        ((1, 2), 0, +1),  # left rotors: the right side goes down
        ((0, 3), 0, -1),
        ((1, 3), 1, +1),  # rear rotors: the nose goes down
        ((0, 2), 1, -1),
        ((2, 3), 2, +1),  # clockwise rotors turn the body counter-clockwise: nose to the left
        ((0, 1), 2, -1),
    ],
)
def test_faster_rotors_turn_it_the_right_way(
    faster: tuple[int, int], axis: int, sense: int
) -> None:
    body = flying()
    speeds = HOVER.copy()
    speeds[list(faster)] *= 1.01
    fly(body, speeds, 0.2)
    rates = body.rates_body * sense
    assert rates[axis] > 1e-3
    assert np.abs(np.delete(rates, axis)).max() < 1e-9


def test_leaning_right_moves_it_to_the_right_and_nose_down_moves_it_forward() -> None:
    for euler, component, sense in ((("x", 0.1), 1, -1), (("y", 0.1), 0, +1)):
        body = flying()
        body.state[6:10] = Rotation.from_euler(*euler).as_quat(scalar_first=True)
        fly(body, HOVER, 0.5)
        assert sense * body.velocity_site[component] > 0.3


def test_wind_carries_it_along() -> None:
    body = flying()
    body.around[:3] = (0.0, 4.0, 0.0)
    fly(body, HOVER, 2.0)
    assert body.velocity_site[1] > 0.3
    assert abs(body.velocity_site[0]) < 1e-9


@given(angle=st.floats(-math.pi, math.pi))
def test_nothing_depends_on_the_compass(angle: float) -> None:
    """Turning start, velocity and wind about the vertical turns the outcome."""
    turn = Rotation.from_euler("z", angle)
    ends = []
    for rotation in (Rotation.identity(), turn):
        body = flying()
        body.state[3:6] = rotation.apply([2.0, 1.0, 0.0])
        q = rotation * Rotation.from_euler("xy", [0.1, -0.2])
        body.state[6:10] = q.as_quat(scalar_first=True)
        body.around[:3] = rotation.apply([1.0, -3.0, 0.5])
        fly(body, HOVER * 1.01, 0.3)
        ends.append(body.position_site)
    assert turn.apply(ends[0]) == pytest.approx(ends[1], abs=1e-9)


@given(slope=st.floats(-0.05, 0.05), start=st.floats(-20, 20))
def test_it_stands_still_on_its_ground(slope: float, start: float) -> None:
    body = Body(X500, (start, 0.0), 0.3, (slope, 0.0, 1.5))
    fly(body, np.zeros(4), 1.0)
    rest = body.position_site
    assert rest[2] == pytest.approx(slope * start + 1.5, abs=0.01)
    fly(body, np.zeros(4), 1.0)
    assert np.abs(body.position_site - rest).max() < 0.01


def test_it_comes_to_rest_after_a_hard_landing() -> None:
    body = flying(0.0)
    body.state[2], body.state[13:17] = 0.3, 0.0
    body.state[3:6] = (0.5, 0.0, -1.0)
    body.state[6:10] = Rotation.from_euler("x", 0.1).as_quat(scalar_first=True)
    fly(body, np.zeros(4), 3.0)
    assert abs(body.position_site[2]) < 0.01
    assert np.abs(body.velocity_site).max() < 1e-3
    assert body.site_from_body[0] > 0.9999
