"""What a system warns of reaches the pilot once, as a warning."""

from pathlib import Path

import numpy as np

from orchard_cli import mission as missions
from orchard_cli.flight.onboard import OnboardJob, OnboardResult
from orchard_cli.flight.reporter import Reporter
from orchard_cli.model.depth import DepthFrame, d455
from orchard_cli.model.records import LogLine, PlannerRecord, Severity
from orchard_cli.motion.situation import Keep

from ..ideal import Ledger

MISSION = Path(__file__).parents[2] / "missions" / "lemon-field.mission.json"


def result(now, alarm):
    frame = DepthFrame(now, np.zeros((120, 212), dtype=np.uint16), d455(212, 120))
    job = OnboardJob(now, now + 0.3, frame, (), None, None, None)
    record = PlannerRecord(now, now, "keep", "hovering", None)
    return OnboardResult(job, True, Keep("hovering", alarm=alarm), record, None)


def test_an_alarm_is_one_warning_until_it_is_over():
    ledger = Ledger()
    reporter = Reporter(missions.load(MISSION), ledger, ledger, 0.0)
    for now, alarm in enumerate(["", "person in 4.0 m", "person in 4.0 m", "", "person in 4.0 m"]):
        reporter.onboard(result(float(now), alarm))
    told = [(line.time, line.severity) for line in ledger.of(LogLine)]
    assert told == [(1.0, Severity.WARNING), (4.0, Severity.WARNING)]
