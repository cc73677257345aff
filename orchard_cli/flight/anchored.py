"""A vehicle whose position estimate may jump, seen as one that moves without steps.

An autopilot's estimator is reset when its sensors disagree with it for long, and its local origin
may move: its coordinates then jump by metres while the vehicle stays where it is. A setpoint that
is not moved along pulls the vehicle by those metres at once (PX4 #19830). Here the jump is taken
out of all that is told and put into all that is sent: what is flown, the map and the way home stay
where they are beside the vehicle.

A real PX4's positions leave what its velocity explains by at most 0.04 m between two samples.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from orchard_cli.model.arrays import Vector
from orchard_cli.model.vehicle import Answer, Command, Pose, Setpoint, VehicleState, poses_after
from orchard_cli.motion.yaw import wrapped

from .ports import Vehicle

STEP = 0.3  # m that a position may leave what the velocity explains, and
AGILITY = 4.0  # m/s², by which the velocity may have changed unseen between two poses
TURN = 0.3  # rad that a heading may leave what the turn rate explains, and
SPIN = 4.0  # rad/s², likewise
KEPT = 256  # poses


@dataclass(frozen=True, slots=True, eq=False)
class Jump:
    """One step of the estimate that no motion explains."""

    time: float  # s, flight clock
    moved_site: Vector  # (3,) m, from where motion led to where the estimate is now
    turned: float  # rad, the heading's share

    def __str__(self) -> str:
        x, y, z = self.moved_site
        text = f"the position estimate jumped by ({x:+.2f}, {y:+.2f}, {z:+.2f}) m"
        turn = f" and {math.degrees(self.turned):+.0f} degrees" if self.turned else ""
        return f"{text}{turn}; the vehicle is held where it is"


class Anchored:
    """Fits flight/ports.py `Vehicle` around another vehicle.

    Until it is first seen armed the autopilot's coordinates are taken as they are.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        self._last: VehicleState | None = None  # as the vehicle told it
        self._poses: deque[Pose] = deque(maxlen=KEPT)
        self._jumps: list[Jump] = []
        self._airborne = False
        self._shifted = False
        self.shift_site: Vector = np.zeros(3)
        """(3,) m to be added to the autopilot's coordinates now."""

    def state(self) -> VehicleState | None:
        """Newest telemetry, without jumps."""
        told = self._vehicle.state()
        if told is None:
            return None
        self._follow(told)
        if not self._shifted:
            return told
        return replace(told, position_site=told.position_site + self.shift_site)

    def poses(self, since: float) -> tuple[Pose, ...]:
        """Poses after `since`, oldest first, up to that of the newest state asked for."""
        return poses_after(self._poses, since)

    def jumps(self) -> tuple[Jump, ...]:
        """Jumps since the last call."""
        taken, self._jumps = tuple(self._jumps), []
        return taken

    def send(self, setpoint: Setpoint) -> None:
        """Stream a setpoint, in the autopilot's present coordinates."""
        if self._shifted:
            place = setpoint.position_site - self.shift_site
            setpoint = replace(setpoint, position_site=place)
        self._vehicle.send(setpoint)

    def stop_sending(self) -> None:
        """End the setpoint stream."""
        self._vehicle.stop_sending()

    def command(self, command: Command, height: float = math.nan) -> None:
        """Ask for something."""
        self._vehicle.command(command, height)

    def answers(self) -> tuple[Answer, ...]:
        """Answers since the last call."""
        return self._vehicle.answers()

    def close(self) -> None:
        """Let go of the vehicle."""
        self._vehicle.close()

    def _follow(self, told: VehicleState) -> None:
        """Judge every pose since the last one, and keep it where it is without the jumps."""
        self._airborne = self._airborne or told.armed
        last, self._last = self._last, told
        before = None if last is None or told.time < last.time else last.pose
        if last is not None and before is None:
            self._poses.clear()  # the autopilot rebooted: its clock began anew
        since = -math.inf if before is None else before.time
        fresh = [pose for pose in self._vehicle.poses(since) if pose.time <= told.time]
        for pose in fresh:
            self._judge(before, pose, told)
            before = pose
            kept = pose
            if self._shifted:
                kept = replace(pose, position_site=pose.position_site + self.shift_site)
            self._poses.append(kept)
        self._judge(before, told.pose, told)

    def _judge(self, before: Pose | None, pose: Pose, told: VehicleState) -> None:
        if before is None or not self._airborne or pose.time <= before.time:
            return
        dt = pose.time - before.time
        moved = pose.position_site - before.position_site - told.velocity_site * dt
        turned = wrapped(_yaw(pose) - _yaw(before) - float(told.angular_velocity_body[2]) * dt)
        leapt = math.hypot(*moved.tolist()) > STEP + AGILITY / 2 * dt**2
        spun = abs(turned) > TURN + SPIN / 2 * dt**2  # NaN rates: no judgement
        if leapt:
            self.shift_site, self._shifted = self.shift_site - moved, True
        if leapt or spun:
            still = np.zeros(3)
            jump = Jump(pose.time, moved if leapt else still, turned if spun else 0.0)
            self._jumps.append(jump)


def _yaw(pose: Pose) -> float:
    w, x, y, z = pose.site_from_body.tolist()
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
