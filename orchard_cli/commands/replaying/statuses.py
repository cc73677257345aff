"""A log as the pictures that the pilot's screen showed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Generic, TypeVar

import numpy as np

from orchard_cli.analysis.aligned import TRIED
from orchard_cli.analysis.along import places
from orchard_cli.analysis.lines import planned
from orchard_cli.flight.safety import Phase
from orchard_cli.flight.status import Status
from orchard_cli.model.flown import FlownLog
from orchard_cli.model.mission import Mission
from orchard_cli.model.records import PlannerRecord, SafetyRecord, SprayRecord

PERIOD = 0.25  # s of flight between two pictures

T = TypeVar("T", PlannerRecord, SafetyRecord, SprayRecord)


class _Newest(Generic[T]):
    """The newest record up to a time that only goes on."""

    def __init__(self, records: Sequence[T]) -> None:
        self._records: Sequence[T] = records
        self._next = 0

    def at(self, time: float) -> T | None:
        """None before the first."""
        while self._next < len(self._records) and self._records[self._next].time <= time:
            self._next += 1
        return self._records[self._next - 1] if self._next else None


def statuses(log: FlownLog, mission: Mission) -> Iterator[Status]:
    """Four pictures a second of flight, from the first odometry to the last."""
    track = log.odometry
    safety, planner, spray = _Newest(log.safety), _Newest(log.planner), _Newest(log.spray)
    offset = planned(mission).offset(track.positions_site).distance
    step = max(1, len(track.times) // TRIED)
    along = places(mission.waypoints_site, track.positions_site[::step])
    avoidances, was = 0, False
    begin, end = float(track.times[0]), float(track.times[-1])
    for now in np.arange(begin, end, PERIOD).tolist():
        here = int(np.searchsorted(track.times, now, side="right")) - 1
        state, thought, pump = safety.at(now), planner.at(now), spray.at(now)
        phase = _phase(state)
        avoidances += phase is Phase.AVOIDANCE and not was
        was = phase is Phase.AVOIDANCE
        progress = float(along[min(here // step, len(along) - 1)]) / mission.route_length
        yield Status(
            time=now - begin,
            phase=phase,
            why=state.why if state else "",
            mode="as logged",
            height=float(track.positions_site[here, 2]) - mission.takeoff_ground,
            speed=float(np.linalg.norm(track.velocities_site[here])),
            cross_track=float(offset[here]),
            progress=min(progress, 1.0),
            remaining=end - now,
            battery=_battery(log, now),
            frame_age=now - thought.frame_time if thought else math.nan,
            silence=now - float(track.times[here]),
            cycle_ms=thought.stages_ms.get("cycle", math.nan) if thought else math.nan,
            decision=f"{thought.decision}: {thought.why}" if thought else "",
            avoidances=avoidances,
            spraying=pump.on if pump else False,
            hazards=state.faults if state else (),
        )


def _phase(state: SafetyRecord | None) -> Phase:
    """A log of another version may name a phase that is not known here: shown as the first."""
    known = {phase.value: phase for phase in Phase}
    return known.get(state.phase, next(iter(Phase))) if state else next(iter(Phase))


def _battery(log: FlownLog, now: float) -> float:
    before = int(np.searchsorted(log.battery_times, now, side="right"))
    return float(log.battery_shares[before - 1]) if before else math.nan
