"""The control cascade: signs, limits, and what it must bear."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from orchard_cli.simulator.autopilot.parameters import Parameters
from orchard_cli.simulator.body import X500, Body
from orchard_cli.simulator.control import FREE, Cascade, Demand, Motors, _kernels

TICK = 0.01
TRUE = np.zeros(9)  # an estimate without error


def hovering(height: float = 5.0, yaw: float = 0.0) -> tuple[Body, Cascade]:
    body = Body(X500, (0.0, 0.0), yaw)
    body.state[2] = height
    body.state[13:17] = X500.hover_speed
    return body, Cascade(Parameters(), TICK)


def demand(
    position: object = FREE, velocity: object = FREE, acceleration: object = FREE, yaw: float = 0.0
) -> Demand:
    return Demand(
        np.array(position, dtype=float), np.array(velocity, dtype=float),
        np.array(acceleration, dtype=float), yaw, 0.0,
        speed=12.0, climb=3.0, descent=1.5, tilt=math.radians(45), collective_min=0.12,
    )  # fmt: skip


def fly(body: Body, cascade: Cascade, wanted: Demand, seconds: float) -> None:
    for _ in range(round(seconds / TICK)):
        cascade.fly(body, TRUE, wanted, Motors.FLYING)


def yaw_of(body: Body) -> float:
    return float(Rotation.from_quat(body.site_from_body, scalar_first=True).as_euler("ZYX")[0])


@pytest.mark.parametrize("yaw", [0.0, 2.0, -1.2])
@pytest.mark.parametrize("goal", [(2.0, 0.0, 5.0), (0.0, -2.0, 5.0), (-1.0, 1.0, 6.0)])
def test_it_goes_where_it_is_told_whichever_way_it_looks(
    goal: tuple[float, float, float], yaw: float
) -> None:
    body, cascade = hovering(yaw=yaw)
    fly(body, cascade, demand(goal, yaw=yaw), 15.0)
    assert body.position_site == pytest.approx(goal, abs=0.05)
    assert yaw_of(body) == pytest.approx(yaw, abs=0.01)


@given(start=st.floats(-3.1, 3.1), wanted=st.floats(-3.1, 3.1))
def test_it_turns_to_the_wanted_yaw_the_short_way(start: float, wanted: float) -> None:
    body, cascade = hovering(yaw=start)
    turn = math.remainder(wanted - start, math.tau)
    fly(body, cascade, demand((0, 0, 5), yaw=wanted), 0.3)
    if 0.1 < abs(turn) < 3.0:
        assert math.copysign(1, body.rates_body[2]) == math.copysign(1, turn)
    fly(body, cascade, demand((0, 0, 5), yaw=wanted), 5.7)
    assert math.remainder(yaw_of(body) - wanted, math.tau) == pytest.approx(0.0, abs=0.02)


def test_a_yaw_step_peaks_at_px4s_rate() -> None:
    body, cascade = hovering()
    peak = 0.0
    for _ in range(200):
        cascade.fly(body, TRUE, demand((0, 0, 5), yaw=math.pi / 2), Motors.FLYING)
        peak = max(peak, abs(float(body.rates_body[2])))
    assert 135 < math.degrees(peak) < 155  # px4/README §3: 144 to 150 deg/s


def test_a_velocity_demand_alone_is_flown() -> None:
    body, cascade = hovering()
    fly(body, cascade, demand(velocity=(1.0, -0.5, 0.3)), 6.0)
    assert body.velocity_site == pytest.approx((1.0, -0.5, 0.3), abs=0.05)


def test_an_acceleration_demand_leans_towards_it() -> None:
    body, cascade = hovering()
    fly(body, cascade, demand(acceleration=(0.0, 1.0, 0.0)), 1.0)
    assert body.velocity_site[1] == pytest.approx(0.9, abs=0.2)
    assert abs(body.velocity_site[0]) < 0.01


def test_a_feed_forward_takes_away_the_lag() -> None:
    """Position only lags by v / MPC_XY_P; with its velocity it does not (px4/README §3)."""
    lags = []
    for velocity in (FREE, (1.0, 0.0, 0.0)):
        body, cascade = hovering()
        for tick in range(1500):
            wanted = demand((tick * TICK, 0, 5), velocity)
            cascade.fly(body, TRUE, wanted, Motors.FLYING)
        lags.append(1499 * TICK - body.position_site[0])
    assert lags[0] == pytest.approx(1.0 / 0.95, abs=0.05)
    assert abs(lags[1]) < 0.05


def test_it_never_leans_or_hurries_beyond_its_limits() -> None:
    body, cascade = hovering()
    lean = speed = climb = 0.0
    for tick in range(1500):
        goal = (300.0, 0.0, 60.0) if tick < 800 else (0.0, 0.0, 5.0)
        cascade.fly(body, TRUE, demand(goal), Motors.FLYING)
        up = Rotation.from_quat(body.site_from_body, scalar_first=True).apply([0, 0, 1])[2]
        lean = max(lean, math.degrees(math.acos(min(1.0, up))))
        speed = max(speed, float(np.hypot(*body.velocity_site[:2])))
        climb = max(climb, float(body.velocity_site[2]))
    assert 30 < lean < 50  # 45 wanted, and the attitude loop's overshoot
    assert 11 < speed < 12.6
    assert climb < 3.5


@pytest.mark.parametrize("mass", [1.5, 2.9])
def test_it_keeps_its_height_with_another_mass(mass: float) -> None:
    body, cascade = hovering()
    body.load[0] = mass
    fly(body, cascade, demand((0, 0, 5)), 12.0)
    assert body.position_site[2] == pytest.approx(5.0, abs=0.05)


def test_it_keeps_its_place_in_wind() -> None:
    body, cascade = hovering()
    body.around[:3] = (4.0, -3.0, 0.0)
    fly(body, cascade, demand((0, 0, 5)), 25.0)
    assert body.position_site == pytest.approx((0, 0, 5), abs=0.1)


@given(
    collective=st.floats(0, 1),
    torque=st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)),
)
def test_the_mixer_stays_within_the_rotors_and_never_turns_a_torque_around(
    collective: float, torque: tuple[float, float, float]
) -> None:
    speeds, constants = np.empty(4), X500.flat()
    _kernels.mix(collective, np.array(torque), constants, speeds)
    assert (speeds >= X500.speed_idle - 1e-9).all()
    assert (speeds <= X500.speed_max + 1e-9).all()
    body = Body(X500, (0.0, 0.0), 0.0)
    body.state[2], body.state[13:17] = 9.0, speeds
    body.around[:3] = 0.0
    made = body.derivative(speeds)[10:13] * body.load[1:4]
    idle = 4 * X500.thrust * X500.speed_idle**2  # N, which a rotor that should stand still makes
    trace = idle * np.array([X500.arm, X500.arm, X500.moment])
    assert (np.array(torque) * made > -trace).all()


@given(
    collective=st.floats(0.4, 0.6),
    torque=st.tuples(*[st.floats(-0.1, 0.1)] * 3),
)
def test_the_mixer_gives_what_it_is_asked_for_where_there_is_room(
    collective: float, torque: tuple[float, float, float]
) -> None:
    speeds = np.empty(4)
    _kernels.mix(collective, np.array(torque), X500.flat(), speeds)
    shares = (speeds / X500.speed_max) ** 2
    assert shares.mean() == pytest.approx(collective)
    arms = 4 * X500.arm * math.sqrt(0.5)
    scale = X500.thrust * X500.speed_max**2 * np.array([arms, arms, 4 * X500.moment])
    body = Body(X500, (0.0, 0.0), 0.0)
    body.state[2], body.state[13:17] = 9.0, speeds
    made = body.derivative(speeds)[10:13] * body.load[1:4]
    assert made == pytest.approx(np.array(torque) * scale, abs=1e-9)


def test_the_compiled_kernel_does_what_its_source_says() -> None:
    ends = []
    for kernel in (_kernels.fly, _kernels.fly.py_func):
        body, memory = hovering()[0], np.zeros(24)
        setpoint = np.array([1.0, -2.0, 6.0, 0.5, 0.0, 0.0, *FREE, 0.7, 0.0])
        limits = np.array([12.0, 3.0, 1.5, 0.78, 0.12])
        table = Cascade(Parameters(), TICK)._gains
        for _ in range(20):
            kernel(body.state, TRUE, setpoint, limits, table, 2, body.around, body.load,
                   body.constants, 0.002, 5, memory)  # fmt: skip
        ends.append(body.state.copy())
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)
