"""Gathers what is seen, from telemetry, frames and the helm, to one `Seen` for the decision."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.model.mission import Mission
from orchard_cli.model.vehicle import FlightMode, Landed, Setpoint, VehicleState

from .anchored import Anchored
from .boundary import NO_EDGE, Margins, area_of, margins
from .helm import Helm
from .lookout import Lookout
from .preflight import not_ready
from .safety import Phase, Request, Seen, Tolerances
from .stage import Stage
from .tracking import Follower
from .wind import Lean

CLIMBED = 1.2  # m below its height at which PX4 calls a take-off done (0.8 m) and a margin
AT_ROUTE = 1.0  # m, and
ALONG_ROUTE = 0.25  # rad, between the vehicle and where it should stand before a route begins


@dataclass(frozen=True, slots=True)
class Told:
    """What the loop knows besides."""

    request: Request | None  # of the operator
    refused: str | None  # what the autopilot said when it last refused
    tank_empty: bool
    log_lost: bool  # records so far


class Observer:
    """Sees for the decision. Remembers only since when things have been so."""

    def __init__(
        self,
        mission: Mission,
        vehicle: Anchored,
        helm: Helm,
        lookout: Lookout,
        tolerances: Tolerances,
    ) -> None:
        self._mission = mission
        self._begin = float(mission.trajectory.control_points_site[0, 2])  # m, the route's height
        self._vehicle = vehicle
        self._helm = helm
        self._lookout = lookout
        self._tolerances = tolerances
        self._area = area_of(mission)
        self._follower = Follower()
        self._lean = Lean()
        self._wanted: Vector = np.zeros(3)  # m/s², asked for last
        self._fixed = math.inf  # s, when the autopilot last had a position on earth
        self._streaming = False
        self._upright = math.inf  # s, when the vehicle was last seen flying as it should
        self._jumped = -math.inf  # s, when the position estimate last jumped

    @property
    def widening(self) -> float:
        """m that plans have to keep on top of their clearance."""
        return self._follower.tracking.widening

    def jumped(self, now: float) -> None:
        """The position estimate jumped."""
        self._jumped = now

    def sent(self, setpoint: Setpoint | None) -> None:
        """This was streamed; None: nothing is."""
        self._streaming = setpoint is not None
        self._wanted = np.zeros(3) if setpoint is None else setpoint.acceleration_site
        if setpoint is None:
            self._follower.stopped()
        else:
            self._follower.sent(setpoint)

    def gather(self, stage: Stage, state: VehicleState | None, told: Told, now: float) -> Seen:
        """Everything that a decision is made from."""
        guidance, lookout = self._helm.guidance, self._lookout
        behind = self._behind(state, now)
        self._judge(state)
        return Seen(
            vehicle=state,
            silence=math.inf if state is None else now - min(state.heard, state.time),
            frame_age=lookout.frame_age(now),
            planner_age=lookout.planner_age(now),
            off_track=math.hypot(*behind.tolist()),
            tracking=self._follower.tracking,
            falling=self._falling(state, float(behind[2]), now),
            blocked=guidance.blocked,
            avoiding=guidance.avoiding(now),
            routed=guidance.reference is not None,
            joining=guidance.pending,
            climbed=self._climbed(state),
            still=guidance.still(now),
            joined=self._joined(state, behind, now),
            route_done=guidance.arrived(now),
            return_share=self._return_share(now),
            critical_share=self._mission.limits.reserve / 2,
            not_ready=self._not_ready(stage, state, now),
            since_jump=now - self._jumped,
            margins=self._margins(state),
            strayed=math.hypot(*self._vehicle.shift_site.tolist()),
            haven=lookout.haven(now),
            sight=lookout.sight,
            obstacle_near=lookout.emergency,
            alive=lookout.alive,
            unfixed=self._unfixed(state, now),
            lean=self._lean.angle,
            tank_empty=told.tank_empty,
            log_lost=told.log_lost,
            request=told.request,
            refused=told.refused,
        )

    def _judge(self, state: VehicleState | None) -> None:
        """How well the autopilot follows, and how far it leans for it."""
        if state is not None and self._obeyed(state):
            self._follower.judge(state.position_site, state.time)
            self._lean.after(state, self._wanted)

    def _not_ready(self, stage: Stage, state: VehicleState | None, now: float) -> tuple[str, ...]:
        """Reasons against arming, while that matters."""
        if stage.phase is not Phase.PREFLIGHT:
            return ()
        ages = self._lookout.frame_age(now), self._lookout.planner_age(now)
        return not_ready(self._mission, state, *ages, self._tolerances)

    def _margins(self, state: VehicleState | None) -> Margins:
        """From the edges of the fence and the keep-outs."""
        if state is None:
            return NO_EDGE
        shift, deceleration = self._vehicle.shift_site, self._mission.limits.acceleration
        return margins(self._area, state, shift, deceleration)

    def _behind(self, state: VehicleState | None, now: float) -> Vector:
        """(3,) m from the vehicle to where it should be; zero when nothing is streamed."""
        if state is None or not self._obeyed(state):
            return np.zeros(3)
        behind: Vector = self._helm.guidance.position(now) - state.position_site
        return behind

    def _obeyed(self, state: VehicleState) -> bool:
        """Whether the autopilot flies what is streamed."""
        return self._streaming and state.mode is FlightMode.OFFBOARD

    def _falling(self, state: VehicleState | None, under: float, now: float) -> float:
        """Seconds for which the vehicle has been far under its setpoint, or on the ground."""
        down = state is not None and state.landed is Landed.ON_GROUND
        if not down and under <= self._tolerances.sunk:
            self._upright = now
        return now - min(self._upright, now)

    def _unfixed(self, state: VehicleState | None, now: float) -> float:
        """Seconds for which the autopilot has had no GPS fix."""
        if state is None or state.fixed:
            self._fixed = now
        return now - min(self._fixed, now)

    def _climbed(self, state: VehicleState | None) -> bool:
        return state is not None and float(state.position_site[2]) > self._begin - CLIMBED

    def _joined(self, state: VehicleState | None, behind: Vector, now: float) -> bool:
        """Whether vehicle and setpoint both stand at the route's next point, looking along it."""
        guidance = self._helm.guidance
        if state is None or state.mode is not FlightMode.OFFBOARD or not guidance.joined(now):
            return False
        near = math.hypot(*behind.tolist()) < AT_ROUTE
        return near and guidance.yaw_error(state.yaw_site) < ALONG_ROUTE

    def _return_share(self, now: float) -> float:
        """Share of the battery below which to turn back, with half of the reserve.

        Nearer to the end of the route than to its beginning, flying on is the shorter way down:
        then there is none.
        """
        limits, guidance = self._mission.limits, self._helm.guidance
        back = self._helm.trail.length / limits.speed
        if guidance.reference is not None and guidance.remaining(now) < back:
            return 0.0
        return back / limits.endurance + limits.reserve / 2
