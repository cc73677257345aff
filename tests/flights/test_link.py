"""The MAVSDK link against the simulated autopilot: what it hears, mends and survives."""

import math
import time

import numpy as np
import pytest

from orchard_cli.errors import LinkError
from orchard_cli.model.site import HeightReference, SiteOrigin
from orchard_cli.model.vehicle import Command, FlightMode, Landed, Setpoint
from orchard_cli.model.world import World
from orchard_cli.simulator import SimulatorProcess, SimulatorSettings
from orchard_cli.vehicle import connect, inspect_link

pytestmark = pytest.mark.flight
ORIGIN = SiteOrigin(23.158, 113.352, 30.0, HeightReference.AMSL, math.radians(70.0))
START = (12.0, -3.0)
YAW = 0.4


def simulator(**settings):
    values = {"port": 0, "autopilot_port": 0, "camera": None, "speed_factor": 4.0}
    return SimulatorProcess.start(
        World("empty"), ORIGIN, START, YAW, SimulatorSettings(**{**values, **settings})
    )


def until(condition, patience=20.0):
    end = time.monotonic() + patience
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError("waited in vain")


@pytest.fixture
def flying():
    running = simulator()
    vehicle = connect(running.url, ORIGIN, running.clock.now, ground_site=1.5)
    yield running, vehicle
    vehicle.close()
    running.close()


def test_it_knows_where_it_stands_in_the_site_frame_and_which_way_it_looks(flying):
    _, vehicle = flying
    state = until(lambda: vehicle.state() and vehicle.state().ready and vehicle.state())
    assert state.position_site[:2] == pytest.approx(START, abs=0.6)
    assert state.position_site[2] == pytest.approx(1.5, abs=0.05)
    assert state.yaw_site == pytest.approx(YAW, abs=0.05)
    assert state.landed is Landed.ON_GROUND
    assert not state.armed


def test_a_setpoint_to_the_left_moves_it_to_the_left_and_a_turn_left_turns_it_left(flying):
    running, vehicle = flying
    until(lambda: vehicle.state() and vehicle.state().ready)
    vehicle.command(Command.ARM)
    until(lambda: vehicle.state().armed)
    vehicle.command(Command.TAKEOFF, 3.0)
    until(lambda: vehicle.state().landed is Landed.IN_AIR)
    until(lambda: vehicle.state().mode is FlightMode.HOLD)
    until(lambda: abs(vehicle.state().position_site[2] - 4.5) < 0.4)  # 1.5 m ground + 3 m
    start = vehicle.state()
    goal = start.position_site + np.array([1.0, 2.0, 0.5])

    def stream():
        vehicle.send(
            Setpoint(running.clock.now(), goal, np.zeros(3), np.zeros(3), start.yaw_site + 0.5)
        )
        return np.linalg.norm(vehicle.state().position_site - goal) < 0.35

    stream()
    vehicle.command(Command.OFFBOARD)
    until(stream)
    until(lambda: stream() and abs(vehicle.state().yaw_site - start.yaw_site - 0.5) < 0.1)
    vehicle.command(Command.LAND)
    until(lambda: not vehicle.state().armed)


def test_poses_come_at_50_hz_and_again_after_the_autopilot_rebooted():
    running = simulator(speed_factor=1.0)
    port = int(running.url.rsplit(":", 1)[1])
    vehicle = connect(running.url, ORIGIN, time.monotonic)
    try:
        until(lambda: vehicle.state() is not None)
        assert poses_per_second(vehicle) == pytest.approx(50, abs=6)
        running.close()
        time.sleep(4.0)  # MAVSDK calls it disconnected 3 s after the last heartbeat
        running = simulator(speed_factor=1.0, port=port)
        until(lambda: time.monotonic() - vehicle.state().heard < 0.2)
        time.sleep(3.0)
        assert poses_per_second(vehicle) == pytest.approx(50, abs=6)
    finally:
        vehicle.close()
        running.close()


def poses_per_second(vehicle):
    since = vehicle.state().time
    time.sleep(1.5)
    return len(vehicle.poses(since)) / 1.5


def test_unsafe_failsafes_are_found_and_mended(flying):
    _, vehicle = flying
    names = {finding.name for finding in vehicle.unsafe_failsafes(3.5)}
    assert {"COM_OBL_RC_ACT", "RTL_RETURN_ALT"} <= names
    vehicle.mend_failsafes(vehicle.unsafe_failsafes(3.5))
    assert vehicle.unsafe_failsafes(3.5) == ()


def test_a_refusal_comes_back_as_an_answer_in_words(flying):
    _, vehicle = flying
    until(lambda: vehicle.state() and vehicle.state().ready)
    vehicle.command(Command.ARM)
    until(lambda: vehicle.state().armed)
    vehicle.command(Command.TAKEOFF, 3.0)
    until(lambda: vehicle.state().landed is Landed.IN_AIR)
    vehicle.answers()
    vehicle.command(Command.DISARM)
    answer = until(vehicle.answers)[0]
    assert answer.command is Command.DISARM
    assert not answer.accepted
    assert "DENIED" in answer.said


def test_nobody_there_is_told_with_the_place_and_the_limit():
    with pytest.raises(LinkError, match=r"no heartbeat on udpin://127\.0\.0\.1:14999 within 1 s"):
        connect("udpin://127.0.0.1:14999", ORIGIN, time.monotonic, patience=1.0)


def test_a_port_in_use_by_another_flight_is_refused(flying):
    running, _ = flying
    with pytest.raises(LinkError, match="in use by another orchard"):
        connect(running.url, ORIGIN, time.monotonic, patience=1.0)


def test_a_senseless_url_is_told():
    with pytest.raises(LinkError, match="cannot open nonsense"):
        connect("nonsense", ORIGIN, time.monotonic, patience=1.0)


def test_doctor_hears_streams_firmware_and_the_parameters_of_the_simulated_autopilot():
    running = simulator()
    try:
        report = inspect_link(running.url, flight_height=3.5)
    finally:
        running.close()
    assert report.firmware.startswith("1.17.0")
    assert not report.armed
    assert report.fix.startswith("rtk fixed")
    assert min(report.rates.values()) > 15.0
    stock = {parameter.name: parameter.safe for parameter in report.parameters}
    assert stock["COM_OBL_RC_ACT"] is False
    assert stock["RTL_RETURN_ALT"] is False
