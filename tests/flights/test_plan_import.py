"""An exported .plan, imported by MAVSDK and uploaded to the simulated autopilot."""

from __future__ import annotations

import math
from pathlib import Path

import mavsdk
import numpy as np
import pytest
from mavsdk.plugins.mission_raw import MissionRaw

from orchard_cli import mission as missions
from orchard_cli.geometry.geodesy import apart
from orchard_cli.mission.exports import Format, Pump, PumpBy, course, export
from orchard_cli.model.world import World
from orchard_cli.simulator import SimulatorProcess, SimulatorSettings
from orchard_cli.vehicle.link import first_autopilot

pytestmark = pytest.mark.flight
MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.fixture(scope="module")
def system():
    origin = missions.load(MISSIONS / "lemon-field.mission.json").orchard.origin
    settings = SimulatorSettings(port=0, autopilot_port=0, camera=None, speed_factor=4.0)
    running = SimulatorProcess.start(World("empty"), origin, (0.0, 0.0), 0.0, settings)
    mavsdk.log_subscribe(lambda *_: True)
    configuration = mavsdk.Configuration.create_with_component_type(
        mavsdk.ComponentType.COMPANION_COMPUTER
    )
    hub = mavsdk.Mavsdk(configuration)
    yield first_autopilot(hub, running.url, 20.0)
    hub.destroy()
    running.close()


def test_mavsdk_imports_the_plan_item_by_item_and_the_autopilot_keeps_it(system):
    """Complex plan items dropped silently by other tools (MAVSDK #1116, #1163)."""
    mission = missions.load(MISSIONS / "lemon-field.mission.json")
    pump = Pump(PumpBy.ACTUATOR, 1)
    raw = MissionRaw(system)
    plan = export([mission], Format.PLAN, pump).decode()
    imported = raw.import_qgroundcontrol_mission_from_string(plan).mission_items
    raw.upload_mission(imported)
    kept = raw.download_mission()
    way = course(mission)
    for items in (imported, kept):
        flown = [item for item in items if item.command in (16, 22)]
        places = np.array([[item.x * 1e-7, item.y * 1e-7] for item in flown])
        assert apart(places, way.places_wgs84[:, :2]).max() < 0.01  # MAVLink's integers: 0.8 cm
        assert [item.z for item in flown] == pytest.approx(way.heights, abs=0.01)
        pumped = [(item.command == 187, item.param1) for item in items if item.command in (16, 187)]
        on, sprays = False, []
        for is_pump, value in pumped:
            if is_pump:
                on = value > 0
            else:
                sprays.append(on)
        assert sprays == [leg.sprays for leg in way.ways]
    assert all(math.isnan(item.param4) for item in imported if item.command == 16)
