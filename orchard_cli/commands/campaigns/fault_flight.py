"""The flight whose faults are tried: a process of its own, on a real MAVSDK link."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from orchard_cli.commands.conduct import conduct, run_header
from orchard_cli.commands.loading import loaded
from orchard_cli.commands.operator import Operator
from orchard_cli.commands.screen import QuietScreen
from orchard_cli.commands.wiring import Choices, attached, onboard
from orchard_cli.flightlog import McapRecorder
from orchard_cli.model.depth import d455
from orchard_cli.model.mission import Mission
from orchard_cli.simulator import AttachedSimulator, SharedSimulator

from .troubles import LatePoses, TroubledWorker, Troubles


def fly(
    shared: SharedSimulator, mission: Mission, choices: Choices, log: Path, troubles: Troubles
) -> None:
    """As `orchard fly` does, in a simulator that belongs to somebody else."""
    sys.stderr = open(log.with_suffix(".err"), "w", encoding="utf-8")  # noqa: SIM115  (until the process ends)
    mission = loaded(mission, choices)
    simulator = AttachedSimulator(shared)
    recorder = McapRecorder(log, overwrite=True)
    try:
        with ThreadPoolExecutor(1) as pool:
            warming = pool.submit(onboard, mission, choices, d455(*choices.camera))
            with attached(mission, choices, simulator, warming.result) as rig:
                recorder.write(run_header(mission, choices, rig, b"", True))
                troubled = replace(
                    rig,
                    worker=TroubledWorker(rig.worker, troubles),
                    vehicle=LatePoses(rig.vehicle, troubles, rig.clock.now),
                )
                operator = Operator()
                with operator.listening():
                    conduct(mission, troubled, recorder, operator, QuietScreen())
    finally:
        recorder.close()
