"""Estimator resets and a local origin that moves, over MAVLink: the vehicle stays where it is."""

import time

import numpy as np
import pytest

from orchard_cli.flight.anchored import Anchored
from orchard_cli.model.vehicle import Command, FlightMode, Landed, Setpoint
from orchard_cli.simulator.faults import EstimateJump, OriginMove
from orchard_cli.vehicle import connect
from tests.flights.test_link import ORIGIN, simulator, until

pytestmark = pytest.mark.flight


def test_offboard_setpoints_do_not_jump_when_the_estimator_resets_or_the_origin_moves():
    running = simulator(speed_factor=2.0)
    mavsdk = connect(running.url, ORIGIN, running.clock.now)
    vehicle = Anchored(mavsdk)
    try:
        until(lambda: vehicle.state() and vehicle.state().ready)
        vehicle.command(Command.ARM)
        until(lambda: vehicle.state().armed)
        vehicle.command(Command.TAKEOFF, 3.0)
        until(lambda: vehicle.state().landed is Landed.IN_AIR)
        until(lambda: vehicle.state().mode is FlightMode.HOLD)
        place, yaw = vehicle.state().position_site, vehicle.state().yaw_site
        stand = Setpoint(running.clock.now(), place, np.zeros(3), np.zeros(3), yaw)

        def stream(seconds):
            end = running.clock.now() + seconds
            while running.clock.now() < end:
                vehicle.state()
                vehicle.send(stand)
                time.sleep(0.01)

        stream(0.5)
        vehicle.command(Command.OFFBOARD)
        stream(6.0)
        assert vehicle.state().mode is FlightMode.OFFBOARD
        assert vehicle.jumps() == ()
        before = running.truth.take()[-1].position_site
        for fault, jumps, shift in (
            (EstimateJump((3.0, -2.0, 0.8)), 1, (-3.0, 2.0, -0.8)),
            (OriginMove((-40.0, 25.0, -2.0)), 2, (-3.0, 2.0, -0.8)),  # learnt, and taken back
        ):
            running.inject(fault)
            stream(5.0)
            assert len(vehicle.jumps()) == jumps
            assert vehicle.shift_site == pytest.approx(shift, abs=0.15)
            flown = np.array([record.position_site for record in running.truth.take()])
            assert np.linalg.norm(flown - before, axis=1).max() < 0.5
            before = flown[-1]
        vehicle.stop_sending()
        vehicle.command(Command.LAND)
        until(lambda: not vehicle.state().armed)
    finally:
        mavsdk.close()
        running.close()
