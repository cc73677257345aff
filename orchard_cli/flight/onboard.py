"""The onboard cycle: a depth frame in, the map updated, a verdict on the trajectory out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from orchard_cli.geometry.area import Area
from orchard_cli.geometry.poses import interpolate
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.mission import Limits
from orchard_cli.model.records import OccupiedCells, PlannerRecord
from orchard_cli.model.sensors import Sensed
from orchard_cli.model.tank import Load
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import Pose, VehicleState
from orchard_cli.motion.situation import Avoid, Keep, Situation, Stop, Verdict

from .boundary import bounded
from .haven import Haven, Havens
from .ports import Avoidance
from .tracking import widened

MAP_PERIOD = 1.0  # s between two records of the occupied cells
MAP_RADIUS = 7.0  # m around the vehicle


@dataclass(frozen=True, slots=True, eq=False)
class OnboardJob:
    """What one cycle works on."""

    now: float  # s, flight clock
    commit: float  # s, the active trajectory is fixed up to here
    frame: DepthFrame
    poses: tuple[Pose, ...]  # around the frame's time stamp
    vehicle: VehicleState
    active: Trajectory | None  # None: map only
    reference: Trajectory | None
    sensed: Sensed = field(default_factory=Sensed)
    load: Load | None = None  # of the tank; None: no tank
    widening: float = 0.0  # m on top of the clearance, for an autopilot that strays


@dataclass(frozen=True, slots=True, eq=False)
class OnboardResult:
    """What one cycle found."""

    job: OnboardJob
    mapped: bool  # the frame went into the map; without that the verdict says nothing
    verdict: Verdict
    record: PlannerRecord
    occupied: OccupiedCells | None
    haven: Haven | None = None  # where to come down early; looked for as often as the map is told


class Onboard:
    """Owns the map and asks the avoidance system; called by one worker, one job at a time."""

    def __init__(
        self,
        grid: OccupancyGrid,
        avoidance: Avoidance,
        limits: Limits,
        area: Area | None = None,
        havens: Havens | None = None,
    ) -> None:
        """What would leave `area` is not flown; None: no fence and no keep-outs. `havens` looks for
        places to come down early; None: they are not looked for."""
        self._grid = grid
        self._avoidance = avoidance
        self._limits = limits
        self._area = area or Area(np.empty((0, 2)))
        self._havens = havens
        self._mapped = -MAP_PERIOD

    def cycle(self, job: OnboardJob) -> OnboardResult:
        """Map the frame from the pose at its own time stamp, then judge the trajectory."""
        began = perf_counter()
        pose = interpolate(job.poses, job.frame.time)
        if pose is None:
            return self._result(job, False, Keep("no pose at the frame's time"), {}, began)
        self._grid.insert(job.frame, pose)
        self._grid.clear_sphere(job.vehicle.position_site, self._limits.airframe_radius)
        mapped = perf_counter()
        verdict = self._judge(job, pose)
        stages = {
            "map_update": (mapped - began) * 1e3,
            "plan": (perf_counter() - mapped) * 1e3,
            **verdict.stages_ms,
        }
        return self._result(job, True, verdict, stages, began)

    def _judge(self, job: OnboardJob, frame_pose: Pose) -> Verdict:
        if job.active is None or job.reference is None:
            return Keep("nothing to check yet")
        limits = self._limits if job.load is None else job.load.limits(self._limits)
        limits = widened(limits, job.widening)
        verdict = self._avoidance.plan(
            Situation(
                now=job.now,
                commit=job.commit,
                vehicle=job.vehicle,
                active=job.active,
                reference=job.reference,
                grid=self._grid,
                frame=job.frame,
                limits=limits,
                area=self._area,
                frame_pose=frame_pose,
                sensed=job.sensed,
                load=job.load,
            )
        )
        return bounded(verdict, job.active, job.now, job.commit, self._area, limits)

    def _result(
        self,
        job: OnboardJob,
        mapped: bool,
        verdict: Verdict,
        stages: Mapping[str, float],
        began: float,
    ) -> OnboardResult:
        occupied = self._occupied(job)
        haven = None if occupied is None else self._haven(job, occupied)
        words = {Keep: "keep", Avoid: "avoid", Stop: "stop"}
        record = PlannerRecord(
            time=job.now,
            frame_time=job.frame.time,
            decision=words[type(verdict)],
            why=verdict.why,
            blocked_at=verdict.blocked_at,
            stages_ms={**stages, "cycle": (perf_counter() - began) * 1e3},
        )
        return OnboardResult(job, mapped, verdict, record, occupied, haven)

    def _haven(self, job: OnboardJob, occupied: OccupiedCells) -> Haven | None:
        if self._havens is None:
            return None
        here = job.vehicle.position_site
        return self._havens.nearest(here, self._grid, occupied.centres_site)

    def _occupied(self, job: OnboardJob) -> OccupiedCells | None:
        if job.now - self._mapped < MAP_PERIOD:
            return None
        self._mapped = job.now
        centre = job.vehicle.position_site
        cells = self._grid.occupied_cells(centre, MAP_RADIUS)
        return OccupiedCells(job.now, cells, self._grid.settings.cell)
