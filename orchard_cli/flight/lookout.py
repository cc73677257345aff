"""Looks ahead: takes frames and scans, has the onboard cycle judge them, tells the helm."""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.records import NewTrajectory, Severity
from orchard_cli.model.sensors import Sensed
from orchard_cli.model.tank import Load
from orchard_cli.model.vehicle import VehicleState
from orchard_cli.motion.situation import Avoid, Keep

from .anchored import Anchored
from .emergency import too_near
from .eyesight import Eyesight, Sight
from .gear import Gear
from .haven import Haven
from .helm import Helm
from .inbox import Inbox
from .onboard import OnboardJob, OnboardResult

HAVEN_AGE = 3.0  # s for which a place to come down is believed to be free
COMMIT = 0.3  # s: an avoidance begins at least this much after it was asked for
POSES_BEFORE = 0.2  # s before a frame from which poses are handed over with it


class Lookout:
    """The loop's eyes. Touches the helm only with answers that came in time."""

    def __init__(self, gear: Gear, vehicle: Anchored, helm: Helm, radius: float) -> None:
        """`radius`: m, of the airframe."""
        self._gear = gear
        self._vehicle = vehicle
        self._helm = helm
        self._radius = radius
        self._inbox = Inbox()
        self._eyesight = Eyesight()
        self._near = 0  # frames on end in which something was too near
        self._alive = False  # the newest answer told of a person or another drone ahead
        self._sensed = Sensed()
        self._planned = -math.inf  # s, when somebody was last seen to look ahead
        self._haven: tuple[Haven | None, float] = (None, -math.inf)
        self._widening = 0.0  # m on top of the clearance

    def frame_age(self, now: float) -> float:
        """s since the newest usable frame was taken."""
        return now - self._inbox.newest

    def planner_age(self, now: float) -> float:
        """s since the newest answer in time."""
        return now - self._planned

    @property
    def sight(self) -> Sight:
        """What is wrong with the images, once it lasts."""
        return self._eyesight.ill

    @property
    def emergency(self) -> bool:
        """Whether something is nearer than hard braking needs, in two images on end."""
        return self._near > 1

    @property
    def alive(self) -> bool:
        """Whether the system tells of somebody ahead."""
        return self._alive

    def haven(self, now: float) -> Haven | None:
        """A place to come down early that was found lately; None: there is none."""
        haven, found = self._haven
        return haven if now - found <= HAVEN_AGE else None

    def look(self, state: VehicleState | None, now: float) -> None:
        """Take the newest frame and the newest scans, and log what is new."""
        frame = self._gear.camera.latest()
        if frame is not None:
            self._gear.recorder.write(frame)
            self._judge(frame, state, now)
        if self._gear.sensors is not None:
            before, self._sensed = self._sensed.scans(), self._gear.sensors.newest()
            known = {(type(scan), scan.time) for scan in before}
            for scan in self._sensed.scans():
                if (type(scan), scan.time) not in known:
                    self._gear.recorder.write(scan)

    def _judge(self, frame: DepthFrame, state: VehicleState | None, now: float) -> None:
        """A frame that cannot be believed is not flown by."""
        if self._eyesight.look(frame, state) is not Sight.GOOD:
            return
        self._inbox.put(frame, now)
        near = state is not None and too_near(frame, state, self._radius)
        self._near = self._near + 1 if near else 0

    def think(
        self, state: VehicleState | None, load: Load | None, widening: float, now: float
    ) -> None:
        """Collect the finished onboard cycle and start the next one.

        `widening`: m that the clearance should grow by. A way round an obstacle is judged by what
        it was planned with; the clearance grows when it is over.
        """
        worker, guidance = self._gear.worker, self._helm.guidance
        result = worker.take(now)
        if isinstance(result, Exception):
            self._gear.reporter.say(now, Severity.ERROR, f"onboard cycle failed: {result!r}")
        elif result is not None:
            self._gear.reporter.onboard(result)
            self._alive = result.verdict.alive
            if result.occupied is not None:
                self._haven = (result.haven, now)
            self._take(result, now)
        frame = self._inbox.take(state.time) if state is not None and worker.idle() else None
        if frame is None or state is None:
            return
        if not guidance.avoiding(now):
            self._widening = widening
        poses = self._vehicle.poses(frame.time - POSES_BEFORE)
        job = OnboardJob(
            now, now + COMMIT, frame, poses, state, guidance.active, guidance.reference,
            self._sensed, load, self._widening,
        )  # fmt: skip
        worker.give(job, now)

    def _take(self, result: OnboardResult, now: float) -> None:
        """Fly a new trajectory, unless it was made for one that is no longer flown.

        Only an answer in time, from a frame that was mapped, shows that somebody looks ahead; a
        way round that came too late shows that nobody does.
        """
        before, verdict = self._helm.guidance.active, result.verdict
        in_time = result.mapped and now <= result.job.commit
        if in_time:
            self._planned = now
        if result.job.active is not before or isinstance(verdict, Keep):
            return
        if not in_time or not self._helm.take(verdict, result.job.commit, now):
            self._planned = -math.inf
            self._gear.reporter.say(now, Severity.WARNING, f"too late to be flown: {verdict.why}")
        after = self._helm.guidance.active
        if after is not None and after is not before:
            guide = verdict.guide_site if isinstance(verdict, Avoid) else np.empty((0, 3))
            self._gear.recorder.write(NewTrajectory(now, after, guide, verdict.why))
