"""What is flown at this moment: the one maker of setpoints.

It stands, or brakes, or joins the route (leg by leg to its start, looking along each), or follows
a trajectory. Position (but for NEAR), velocity and acceleration never step: trajectories are
exchanged only for others that agree up to the instant of the exchange, or while standing.
"""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.model.arrays import Points, Vector
from orchard_cli.model.mission import Limits
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.vehicle import Setpoint, VehicleState
from orchard_cli.motion.braking import brake
from orchard_cli.motion.situation import Avoid, Keep, Stop, Verdict
from orchard_cli.motion.timing import PathLimits, time_path
from orchard_cli.motion.yaw import STEADY, YawRule, heading_ahead, wrapped

LOOK_AHEAD = 2.0  # s: at rest, the nose points along the way to be flown within this
NEAR = 0.03  # m: closer than this a leg is not flown; the setpoint steps by as much
SHORT = 1.0  # m: a leg so short is no reason to turn the nose along it
ALIGNED = math.radians(4.0)


class Guidance:
    """Holds the active trajectory and the reference, and turns them into setpoints."""

    def __init__(self, limits: Limits, yaw_rule: YawRule = STEADY) -> None:
        self._limits = limits
        self._yaw_rule = yaw_rule
        self._active: Trajectory | None = None
        self._reference: Trajectory | None = None
        self._legs: list[Trajectory] = []  # each begins once we stand at its start, looking along
        self._stand = np.zeros(3)
        self._yaw = 0.0
        self._yaw_rate = 0.0
        self._time = -math.inf
        self._avoiding_from = math.inf
        self._avoiding_until = -math.inf
        self._look: float | None = None  # rad, while avoiding
        self.blocked = False

    @property
    def active(self) -> Trajectory | None:
        """The trajectory being flown; None while standing."""
        return self._active

    @property
    def pending(self) -> bool:
        """Whether a route waits to begin."""
        return bool(self._legs)

    @property
    def reference(self) -> Trajectory | None:
        """The route without avoidance, on the flight clock; None until begun."""
        return self._reference

    def avoiding(self, now: float) -> bool:
        """Whether the active trajectory is off the reference at `now`."""
        return self._avoiding_from <= now < self._avoiding_until

    def still(self, now: float) -> bool:
        """Whether the end of what was to be flown has been reached."""
        return self._active is None or now >= self._active.end

    def remaining(self, now: float) -> float:
        """Seconds to the end of what is flown; 0 while standing."""
        return 0.0 if self._active is None else max(self._active.end - now, 0.0)

    def arrived(self, now: float) -> bool:
        """Whether the route has been flown to its end."""
        flown = self._reference is not None and self.still(now)
        return flown and not self.blocked and not self._legs

    def stand(self, state: VehicleState) -> None:
        """Forget every trajectory and stand where the vehicle is, looking where it looks."""
        self._active = self._reference = None
        self._legs = []
        self.blocked = False
        self._stand = state.position_site.copy()
        self._yaw, self._yaw_rate = state.yaw_site, 0.0

    def face(self, yaw_site: float) -> None:
        """Go on turning from where the nose is."""
        self._yaw, self._yaw_rate = yaw_site, 0.0

    def brake(self, now: float, deceleration: float | None = None) -> None:
        """Come to rest along the active trajectory and stand there; None: as the limits say."""
        most = max(self._limits.acceleration, deceleration or 0.0)
        self._legs, self._reference = [], None
        if self._active is not None and now < self._active.end:
            self._active = brake(self._active, now, most)
        self.blocked = False

    def join(self, route: Trajectory, now: float) -> None:
        """From standing: climb or sink to the height of its start, go there, look along it.

        Each way there is a leg of its own, flown looking along it and judged by the planner.
        """
        self._settle(now)
        self.blocked = False
        goal = route.control_points_site[0]
        over = np.array([*self._stand[:2], goal[2]])
        self._legs = [
            self.timed(np.stack([start, end]))
            for start, end in ((self._stand, over), (over, goal))
            if float(np.linalg.norm(end - start)) > NEAR
        ]
        self._legs.append(route)

    def advance(self, now: float) -> None:
        """Begin the next leg towards the route when the one before is done; never the route."""
        if len(self._legs) > 1 and self._aligned(now):
            self.begin(now)

    def joined(self, now: float) -> bool:
        """Whether the route may begin: there, still, and looking along it."""
        return len(self._legs) == 1 and self._aligned(now)

    def begin(self, now: float) -> Trajectory:
        """Fly the next leg from now on; returns it on the flight clock."""
        leg = self._legs.pop(0)
        self._active = self._reference = leg.shifted(now - leg.start)
        self._avoiding_until = -math.inf
        return self._reference

    def _aligned(self, now: float) -> bool:
        still = self.still(now) and not self.blocked
        return still and abs(wrapped(self._target_yaw(now) - self._yaw)) < ALIGNED

    def take(self, verdict: Verdict, commit: float, now: float) -> bool:
        """Fly what the avoidance system answered; False when it came too late to be joined.

        Until `commit` the answer equals the active trajectory.
        """
        if isinstance(verdict, Keep):
            return True
        if self._reference is None or now > commit:
            return False
        if isinstance(verdict, Avoid):
            if not self.avoiding(now):
                self._avoiding_from = verdict.begin
            self._avoiding_until = verdict.rejoin
            self._look = verdict.yaw_site
        self.blocked = isinstance(verdict, Stop)
        self._active = verdict.trajectory
        return True

    def timed(self, points_site: Points) -> Trajectory:
        """A path (n, 3) from rest to rest within the mission's limits, starting at time 0."""
        return time_path(points_site, PathLimits.planned(self._limits)).trajectory

    def setpoint(self, now: float) -> Setpoint:
        """The setpoint for `now`; turns the nose by the time since the last call."""
        dt = min(max(now - self._time, 1e-3), 0.1)
        self._time = now
        self._yaw, self._yaw_rate = self._yaw_rule.turn(
            self._yaw, self._yaw_rate, self._target_yaw(now), dt, self._limits.yaw_rate
        )
        if self._active is None:
            position, velocity, acceleration = self._stand, np.zeros(3), np.zeros(3)
        else:
            state = self._active.at(now)
            position, velocity = state.position_site, state.velocity_site
            acceleration = state.acceleration_site
        return Setpoint(now, position, velocity, acceleration, self._yaw, self._yaw_rate)

    def yaw_error(self, yaw_site: float) -> float:
        """rad between where the vehicle looks and where it is told to look."""
        return abs(wrapped(yaw_site - self._yaw))

    def position(self, now: float) -> Vector:
        """(3,) m: where the vehicle should be."""
        return self._stand if self._active is None else self._active.at(now).position_site

    def _settle(self, now: float) -> None:
        if self._active is not None:
            self._stand = self._active.at(now).position_site
        self._active = self._reference = None

    def _target_yaw(self, now: float) -> float:
        """Along what is flown; standing, or on a short leg, along the next one that is long."""
        ahead = None
        short = self._active is None or _span(self._active) < SHORT
        if self._legs and (short or self.still(now)):
            route = self._legs[-1]
            ahead = _first_heading(next((x for x in self._legs if _span(x) >= SHORT), route))
        elif self._look is not None and self.avoiding(self._time):
            ahead = self._look
        elif self._active is not None:
            rule = self._yaw_rule
            ahead = heading_ahead(self._active, now, rule.ahead, rule.standing)
        return self._yaw if ahead is None else ahead


def _span(leg: Trajectory) -> float:
    """Horizontal distance from the first point of a leg to its last, m."""
    way = leg.control_points_site[-1] - leg.control_points_site[0]
    return float(np.hypot(way[0], way[1]))


def _first_heading(route: Trajectory) -> float | None:
    """Direction in which a route sets out."""
    for ahead in np.arange(LOOK_AHEAD, route.end - route.start, LOOK_AHEAD):
        heading = heading_ahead(route, route.start, float(ahead))
        if heading is not None:
            return heading
    return None
