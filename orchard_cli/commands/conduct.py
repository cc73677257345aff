"""One flight from its equipment: the log's header, and the loop with everything plugged in."""

from __future__ import annotations

import json
import time
import uuid
from dataclasses import asdict
from typing import TYPE_CHECKING

from orchard_cli import __version__
from orchard_cli import mission as missions
from orchard_cli.flight.gear import Ending, Gear
from orchard_cli.flight.ports import Display, Operator, Recorder
from orchard_cli.flight.reporter import Reporter
from orchard_cli.flight.runner import Flight
from orchard_cli.model.mission import Mission
from orchard_cli.model.records import RunHeader
from orchard_cli.motion.yaw import STEADY, YawRule

if TYPE_CHECKING:
    from .wiring import Choices, Equipment


def run_header(
    mission: Mission, choices: Choices, equipment: Equipment, world_file: bytes, simulated: bool
) -> RunHeader:
    """What the log begins with. UTC is read here, once; the flight itself reads its own clock."""
    attachments = {
        "mission.json": missions.dumps(mission).encode(),
        "configuration.json": json.dumps(asdict(choices), default=str).encode(),
    }
    if world_file:
        attachments["world.toml"] = world_file
    return RunHeader(
        run_id=uuid.uuid4().hex,
        system=choices.system,
        tool_version=__version__,
        vehicle=equipment.name,
        site=mission.orchard.name,
        simulated=simulated,
        seed=choices.seed if simulated else None,
        utc_offset=time.time() - equipment.clock.now(),
        mission=mission,
        attachments=attachments,
    )


def conduct(
    mission: Mission,
    equipment: Equipment,
    recorder: Recorder,
    operator: Operator,
    screen: Display,
    yaw_rule: YawRule = STEADY,
) -> Ending:
    """Fly it to its end."""
    gear = Gear(
        vehicle=equipment.vehicle,
        camera=equipment.camera,
        worker=equipment.worker,
        errands=equipment.errands,
        clock=equipment.clock,
        recorder=recorder,
        reporter=Reporter(mission, recorder, screen, equipment.clock.now()),
        operator=operator,
        guard=equipment.guard,
        truth=equipment.truth,
        sensors=equipment.sensors,
        load=equipment.load,
        yaw_rule=yaw_rule,
    )
    return Flight(mission, gear, equipment.tolerances).run()
