"""Tells what happens: to the log on every change, to the screen a few times a second."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Points
from orchard_cli.model.mission import Mission
from orchard_cli.model.records import LogLine, SafetyRecord, Severity, SprayRecord
from orchard_cli.model.vehicle import VehicleState

from .gauge import Gauge
from .onboard import OnboardResult
from .ports import Display, Recorder
from .safety import Seen
from .spray import Spray
from .stage import Decision
from .status import Status

SHOW_PERIOD = 0.25  # s of the flight clock
RECORD_PERIOD = 1.0  # s


class Reporter:
    """Turns each cycle into records and pictures."""

    def __init__(self, mission: Mission, recorder: Recorder, display: Display, now: float) -> None:
        self._route = np.asarray(mission.waypoints_site)[:, :2]
        self._ground = mission.takeoff_ground
        self._clearance = mission.limits.clearance
        self._widest = 0.0  # m on top of it so far
        self._recorder = recorder
        self._display = display
        self._began = now
        self._shown = self._recorded = -math.inf
        self._safety: tuple[object, ...] = ()
        self._spray: Spray | None = None
        self._result: OnboardResult | None = None
        self._avoidances = 0
        self._was_avoiding = False
        self._alarm = ""  # of the last onboard cycle

    def say(self, now: float, severity: Severity, text: str) -> None:
        """A sentence for the log."""
        self._recorder.write(LogLine(now, severity, text))

    def onboard(self, result: OnboardResult) -> None:
        """An onboard cycle ended."""
        self._result = result
        self._recorder.write(result.record)
        alarm = result.verdict.alarm
        if alarm and alarm != self._alarm:
            self.say(result.job.now, Severity.WARNING, alarm)
        self._alarm = alarm
        if result.occupied is not None:
            self._recorder.write(result.occupied)

    def cycle(
        self,
        decision: Decision,
        seen: Seen,
        spraying: Spray | None,
        gauge: Gauge,
        span: tuple[float, float],
        now: float,
    ) -> None:
        """A control cycle ended. `span`: s flown and s left of the active trajectory."""
        if seen.vehicle is not None:
            self._recorder.write(seen.vehicle)
        due = now - self._recorded >= RECORD_PERIOD
        hazards = tuple(hazard.value for hazard in decision.hazards)
        stage = decision.stage
        safety = (stage.phase, stage.why, hazards)
        if due or safety != self._safety:
            self._safety = safety
            self._recorder.write(
                SafetyRecord(
                    now, stage.phase.value, decision.steer.value, stage.why, hazards,
                    seen.tracking.error,
                )
            )  # fmt: skip
        self._stray(seen, now)
        level = None if gauge.load is None else gauge.load.level
        if spraying is not None and (due or spraying != self._spray):
            self._spray = spraying
            on, row, why = spraying.on, spraying.row, spraying.why
            self._recorder.write(SprayRecord(now, on, row, why, level, gauge.used))
        if due:
            self._recorded = now
        self._avoidances += seen.avoiding and not self._was_avoiding
        self._was_avoiding = seen.avoiding
        if now - self._shown >= SHOW_PERIOD:
            self._shown = now
            self._display.show(self._status(decision, seen, span, now))

    def _stray(self, seen: Seen, now: float) -> None:
        """Say so whenever the autopilot needs more room than before."""
        if seen.tracking.widening > self._widest + 1e-9:
            self._widest = seen.tracking.widening
            self.say(now, Severity.WARNING, self._room(seen))

    def _room(self, seen: Seen) -> str:
        """What the autopilot's errors mean for the clearance; empty while they mean nothing."""
        if not seen.tracking.widening:
            return ""
        keeps = self._clearance + seen.tracking.widening
        return (
            f"the autopilot strays {seen.tracking.lasting:.1f} m beside what it is told to fly: "
            f"new ways round keep {keeps:.2f} m"
        )

    def _status(
        self, decision: Decision, seen: Seen, span: tuple[float, float], now: float
    ) -> Status:
        vehicle, record = seen.vehicle, self._result.record if self._result else None
        flown, left = span
        return Status(
            time=now - self._began,
            phase=decision.stage.phase,
            why=decision.stage.why,
            mode=vehicle.mode.value if vehicle else "no telemetry",
            height=float(vehicle.position_site[2]) - self._ground if vehicle else math.nan,
            speed=float(np.linalg.norm(vehicle.velocity_site)) if vehicle else math.nan,
            cross_track=_off_line(self._route, vehicle) if vehicle else math.nan,
            progress=flown / (flown + left) if flown + left > 0 else 0.0,
            remaining=left,
            battery=vehicle.battery_share if vehicle else math.nan,
            frame_age=seen.frame_age,
            silence=seen.silence,
            cycle_ms=record.stages_ms.get("cycle", math.nan) if record else math.nan,
            decision=f"{record.decision}: {record.why}" if record else "",
            avoidances=self._avoidances,
            spraying=self._spray.on if self._spray else False,
            hazards=tuple(filter(None, (*(h.value for h in decision.hazards), self._room(seen)))),
        )


def _off_line(line: Points, vehicle: VehicleState) -> float:
    """Horizontal distance, m, from the vehicle to a polyline (n, 2)."""
    a, b = line[:-1], line[1:]
    along = b - a
    offset = vehicle.position_site[:2] - a
    share = np.clip((offset * along).sum(1) / np.maximum((along * along).sum(1), 1e-12), 0.0, 1.0)
    return float(np.min(np.linalg.norm(offset - share[:, None] * along, axis=1)))
