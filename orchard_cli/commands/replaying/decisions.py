"""Mapping and planning again on a log's depth images, and where decisions differ.

An open loop: whatever is decided now, the vehicle goes where it went then.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.flight.lookout import COMMIT
from orchard_cli.flight.onboard import Onboard, OnboardJob
from orchard_cli.flightlog import read
from orchard_cli.flightlog.frames import depth_frames
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.flown import FlownLog
from orchard_cli.model.mission import Mission
from orchard_cli.model.records import PlannerRecord
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import Pose

from ..analyze_logs import mission_of
from ..benchmarks.frames import in_flight
from ..wiring import Choices, onboard

FLOWN = 0.3  # m: a trajectory that stands nearer to what was commanded is the one that was flown


@dataclass(frozen=True, slots=True)
class Difference:
    """One image on which it decides otherwise now."""

    time: float  # s, flight clock
    logged: str
    logged_why: str
    again: str
    again_why: str


@dataclass(frozen=True, slots=True)
class TurnAgain:
    """A logged decision to leave the path or to stop, and the one of now on the same image."""

    time: float  # s, flight clock
    logged: str
    again: str | None  # None: its image is not in the log


@dataclass(frozen=True, slots=True)
class Rethought:
    """What came of thinking a flight over again."""

    system: str
    cycles: int  # that the log tells of
    frames: int  # that the log holds
    replayed: int
    skipped: int
    same: int
    turns: tuple[TurnAgain, ...]
    differing: tuple[Difference, ...]

    def document(self) -> dict[str, Any]:
        """For --json."""
        return {
            "schema": "orchard-replay/1",
            "system": self.system,
            "cycles": self.cycles,
            "frames": self.frames,
            "replayed": self.replayed,
            "skipped": self.skipped,
            "same": self.same,
            "turns": [
                {"time_s": t.time, "logged": t.logged, "again": t.again} for t in self.turns
            ],
            "differing": [
                {"time_s": d.time, "logged": d.logged, "logged_why": d.logged_why,
                 "again": d.again, "again_why": d.again_why}
                for d in self.differing
            ],
        }  # fmt: skip


def rethink(path: Path, system: str | None) -> Rethought:
    """Raises InputError when the log holds no images, or none with a decision."""
    log = read(path)
    mission = mission_of(log, path)
    cycles = {round(one.frame_time * 1e6): one for one in log.planner}
    chosen = system or log.system
    brain: Onboard | None = None
    frames = skipped = 0
    decided: list[tuple[PlannerRecord, PlannerRecord]] = []
    for frame in depth_frames(path):
        frames += 1
        then = cycles.get(round(frame.time * 1e6))
        if then is None:
            continue
        brain = brain or onboard(mission, Choices(system=chosen), frame.camera)
        job, known = _job(log, mission, frame, then)
        now = brain.cycle(job).record
        if known:
            decided.append((then, now))
        else:
            skipped += 1
    if not frames:
        raise InputError(Fault(str(path), "holds no depth images", "name a log of a whole flight"))
    differing = tuple(
        Difference(then.time, then.decision, then.why, now.decision, now.why)
        for then, now in decided
        if then.decision != now.decision
    )
    return Rethought(
        system=chosen,
        cycles=len(log.planner),
        frames=frames,
        replayed=len(decided),
        skipped=skipped,
        same=len(decided) - len(differing),
        turns=_turns(log, {then.time: now.decision for then, now in decided}),
        differing=differing,
    )


def _turns(log: FlownLog, again: dict[float, str]) -> tuple[TurnAgain, ...]:
    """Each logged decision that an obstacle was the reason of."""
    return tuple(
        TurnAgain(one.time, one.decision, again.get(one.time))
        for one in log.planner
        if one.decision != "keep" and one.blocked_at
    )


def _job(
    log: FlownLog, mission: Mission, frame: DepthFrame, then: PlannerRecord
) -> tuple[OnboardJob, bool]:
    """What the cycle worked on, and whether the trajectory that was flown is known."""
    track = log.odometry
    around = (track.times >= frame.time - 0.25) & (track.times <= then.time + 1e-6)
    poses = tuple(
        Pose(float(t), p, q)
        for t, p, q in zip(
            track.times[around], track.positions_site[around], track.site_from_body[around],
            strict=True,
        )
    )  # fmt: skip
    here = max(int(np.searchsorted(track.times, then.time, side="right")) - 1, 0)
    pose = Pose(float(track.times[here]), track.positions_site[here], track.site_from_body[here])
    reference = _route(log, mission, then.time)
    newer = [one.trajectory for one in log.trajectories if one.time < then.time]
    active = _flown(log, then.time, [*newer[-1:], *([reference] if reference else [])])
    known = active is not None or then.why == "nothing to check yet"
    vehicle = in_flight(pose, track.velocities_site[here])
    job = OnboardJob(
        then.time, then.time + COMMIT, frame, poses, vehicle, active, reference if active else None
    )
    return job, known


def _route(log: FlownLog, mission: Mission, time: float) -> Trajectory | None:
    """The mission's trajectory on the flight clock: it begins when the phase `route` does."""
    begun = [one.time for one in log.safety if one.phase == "route" and one.time <= time]
    return mission.trajectory.shifted(begun[0] - mission.trajectory.start) if begun else None


def _flown(log: FlownLog, time: float, candidates: list[Trajectory]) -> Trajectory | None:
    """The first that what was commanded at that time lies on."""
    commands = log.commands
    if not len(commands.times):
        return None
    here = min(int(np.searchsorted(commands.times, time)), len(commands.times) - 1)
    if abs(commands.times[here] - time) > 0.5:
        return None
    at, place = float(commands.times[here]), commands.positions_site[here]
    for one in candidates:
        if one.end > at and np.linalg.norm(one.at(at).position_site - place) < FLOWN:
            return one
    return None
