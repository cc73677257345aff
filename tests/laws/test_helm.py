"""What is left of a route that was interrupted can always be flown, wherever that was."""

import numpy as np
import pytest

from orchard_cli.campaign.faults import FAULTS
from orchard_cli.commands.campaigns import fault_world
from orchard_cli.flight.helm import Helm
from orchard_cli.flight.safety import Hazard, Phase
from orchard_cli.flight.stage import Decision, Stage, Steer
from orchard_cli.flight.worker import InlineWorker
from orchard_cli.model.vehicle import FlightMode, Landed, VehicleState


def told(steer, cause=None):
    return Decision(Stage(Phase.ROUTE, 0.0, "", cause=cause), steer, None, ())


def state(now, helm):
    place = helm.guidance.position(now)
    return VehicleState(
        now, place, np.zeros(3), np.array([1.0, 0, 0, 0]), np.zeros(3),
        True, FlightMode.OFFBOARD, Landed.IN_AIR, now, 1.0, 16.0, True,
    )  # fmt: skip


@pytest.mark.parametrize("before", [1e-6, 0.0005, 0.02, 0.5, 3.0])
def test_a_hold_at_the_very_end_of_the_route_leaves_a_way_that_can_be_flown(before):
    mission = fault_world.mission(FAULTS["SIGKILL"])
    helm = Helm(mission, InlineWorker(lambda errand: errand()))
    start = mission.trajectory.control_points_site[0]
    standing = VehicleState(
        0.0, start, np.zeros(3), np.array([1.0, 0, 0, 0]), np.zeros(3),
        True, FlightMode.OFFBOARD, Landed.IN_AIR, 0.0, 1.0, 16.0, True,
    )  # fmt: skip
    now = 0.0
    helm.steer(told(Steer.JOIN), standing, now)
    while not helm.guidance.joined(now):
        now += 0.02
        helm.steer(told(Steer.JOIN), state(now, helm), now)
    helm.steer(told(Steer.FOLLOW), state(now, helm), now)
    now = helm.guidance.active.end - before
    helm.steer(told(Steer.STAND, Hazard.FRAME_LATE), state(now, helm), now)
    now += 10.0
    until = now + 60.0
    while not helm.guidance.joined(now):
        assert now < until
        now += 0.02
        helm.steer(told(Steer.JOIN), state(now, helm), now)
    helm.steer(told(Steer.FOLLOW), state(now, helm), now)
    end = helm.guidance.active.at(helm.guidance.active.end).position_site
    assert end == pytest.approx(
        mission.trajectory.at(mission.trajectory.end).position_site, abs=0.02
    )
