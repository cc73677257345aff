"""An ideal vehicle for tests of the loop: goes exactly where it is sent, at once.

Fits flight/ports.py Clock, Vehicle and Camera on one simulated time; faults can be switched on.
"""

from __future__ import annotations

import math

import numpy as np

from orchard_cli.geometry.rotations import from_yaw_pitch_roll
from orchard_cli.model.depth import DepthFrame, d455
from orchard_cli.model.vehicle import Answer, Command, FlightMode, Landed, Pose, VehicleState
from orchard_cli.simulator.scene import Scene

FRAME_PERIOD = 1 / 15
CLIMB = 10.0  # m/s
SETTLE = 0.3  # s at height before the take-off is over
STANDING = np.array([0.0, 0.0, 0.15])  # m, legs: the camera is never in the ground


def _settled(ideal):
    if ideal.mode is FlightMode.TAKEOFF:
        ideal.mode = FlightMode.HOLD


class IdealWorld:
    """Time, and what is in it."""

    def __init__(self, world, start_site, yaw=0.0, camera=(212, 120)):
        self.scene = Scene(world)
        self.time = 0.0
        self.position = np.array([*start_site, 0.0])
        self.velocity = np.zeros(3)
        self.yaw = yaw
        self.armed = False
        self.mode = FlightMode.HOLD
        self.landed = Landed.ON_GROUND
        self.battery = 1.0
        self.answered: list[Answer] = []
        self.asked: list[Command] = []
        self.setpoint = None
        self.climb_to = None
        self.setpoints = []
        self.history: list[Pose] = []
        self.offset = np.zeros(3)  # m, by which what it tells and takes is off
        self.velocities = {}  # by time of the pose
        self.stray = 0.0  # m, how far it swings beside where it is sent
        self.deaf = False
        self.blind = False
        self.refuse: dict[Command, str] = {}
        self.pose_delay = 0.0  # s, by which telemetry lags
        self.pumped = []  # (time, on)
        self.events = []  # (time, callable(self))
        self.model = d455(*camera)
        self._frames = 0
        self._fresh = None

    # Clock
    def now(self):
        return self.time

    def sleep_until(self, time):
        while self.time < time - 1e-9:
            self._advance(0.01)

    def _advance(self, dt):
        self.time = round(self.time + dt, 6)
        for event in [e for e in self.events if e[0] <= self.time]:
            self.events.remove(event)
            event[1](self)
        if self.armed:
            self.battery -= dt / 600
        if self.mode is FlightMode.OFFBOARD and self.setpoint is not None:
            s = self.setpoint
            self.position, self.velocity = s.position_site - self.offset, s.velocity_site
            self.yaw = s.yaw_site
            side = np.array([-math.sin(self.yaw), math.cos(self.yaw), 0.0])
            self.position = self.position + self.stray * math.sin(0.7 * self.time) * side
        if self.climb_to is not None:
            self.velocity = np.array([0.0, 0.0, CLIMB])
            self.position = self.position + self.velocity * dt
            if self.position[2] >= self.climb_to:
                self.position[2] = self.climb_to
                self.climb_to, self.velocity = None, np.zeros(3)
                self.events.append((self.time + SETTLE, _settled))
        if self.mode is FlightMode.LAND and self.landed is not Landed.ON_GROUND:
            self.position = self.position - [0, 0, 0.7 * dt]
            if self.position[2] <= 0:
                self.landed, self.armed, self.mode = Landed.ON_GROUND, False, FlightMode.HOLD
        if not self.deaf:
            pose = self._pose()
            told = pose.position_site + self.offset
            self.history.append(Pose(pose.time, told, pose.site_from_body))
            self.velocities[self.time] = self.velocity
        if not self.blind and self.time >= self._frames * FRAME_PERIOD:
            pose = self._pose()
            depth = self.scene.render(
                self.model,
                pose.position_site + STANDING,
                pose.site_from_body,
                self.time,
                self._frames,
            )
            self._fresh = DepthFrame(self.time, depth, self.model)
            self._frames += 1

    def _pose(self):
        return Pose(self.time, self.position, from_yaw_pitch_roll(self.yaw))

    # Vehicle
    def state(self):
        known = [p for p in self.history[-60:] if p.time <= self.time - self.pose_delay]
        if not known:
            return None
        pose = known[-1]
        return VehicleState(
            pose.time, pose.position_site, self.velocities[pose.time],
            pose.site_from_body, np.zeros(3),
            self.armed, self.mode, self.landed, pose.time, self.battery, 16.0, True,
        )  # fmt: skip

    def poses(self, since):
        newest = self.time - self.pose_delay
        return tuple(p for p in self.history[-200:] if since < p.time <= newest)

    def send(self, setpoint):
        self.setpoint = setpoint
        self.setpoints.append(setpoint)

    def pump(self, on):
        self.pumped.append((self.time, on))

    def stop_sending(self):
        self.setpoint = None

    def command(self, command, height=float("nan")):
        self.asked.append(command)
        if self.deaf:
            return
        if command in self.refuse:
            self.answered.append(Answer(command, False, self.refuse[command], self.time))
            return
        self.answered.append(Answer(command, True, "accepted", self.time))
        if command is Command.ARM:
            self.armed = True
        elif command is Command.TAKEOFF:
            self.climb_to = height
            self.landed, self.mode = Landed.IN_AIR, FlightMode.TAKEOFF
        elif command is Command.OFFBOARD:
            self.mode = FlightMode.OFFBOARD
        elif command is Command.LAND:
            self.mode = FlightMode.LAND

    def answers(self):
        taken, self.answered = tuple(self.answered), []
        return taken

    # Camera
    def latest(self):
        frame, self._fresh = self._fresh, None
        return frame

    def close(self):
        pass


class Ledger:
    """Keeps every record, shows nothing, asks for what it was told to ask; a recorder, a display,
    an operator and a guard in one."""

    def __init__(self, requests=()):
        self.records = []
        self.losses = {}
        self.requests = list(requests)  # (time, Request)
        self.clock = None

    def write(self, record):
        self.records.append(record)

    def close(self):
        pass

    def show(self, status):
        self.status = status

    def request(self):
        if self.requests and self.clock is not None and self.clock() >= self.requests[0][0]:
            return self.requests.pop(0)[1]
        return None

    def feed(self):
        pass

    def disarm(self):
        pass

    def of(self, kind):
        return [record for record in self.records if isinstance(record, kind)]
