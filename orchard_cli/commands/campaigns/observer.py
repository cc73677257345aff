"""One fault, tried: flies, strikes in the phase asked for, and watches from outside."""

from __future__ import annotations

import contextlib
import math
import multiprocessing
import signal
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from orchard_cli.campaign.faults import DOWN, STILL, Fault, Observed, Reaction
from orchard_cli.commands.wiring import start_simulator
from orchard_cli.errors import InputError
from orchard_cli.flightlog import read
from orchard_cli.geometry.clearance import clearance
from orchard_cli.model.mission import Mission
from orchard_cli.model.world import World
from orchard_cli.simulator.mavlink.relay import Heard, Relay, free_port

from . import fault_world
from .fault_flight import fly
from .striking import EVIDENCE, STRIKES, Scene
from .troubles import Troubles

PERIOD = 0.05  # s simulated between two looks
START_LIMIT = 300.0  # s of real time until it is armed: kernels may have to be compiled
REAL_LIMIT = 150.0  # s of real time after that
AFTER = 8.0  # s that are watched once nothing flies it any more


@dataclass(slots=True)
class Samples:
    """What was seen, row by row."""

    rows: list[tuple[float, ...]] = field(default_factory=list)
    modes: list[str] = field(default_factory=list)
    armed: list[bool] = field(default_factory=list)
    contact: str = ""


def observe(fault: Fault, phase: str, folder: Path, factor: float) -> Observed:
    """Raises LinkError when the simulator cannot be started."""
    context = multiprocessing.get_context("spawn")
    mission, world = fault_world.mission(fault), fault_world.world()
    choices = fault_world.choices(fault, factor)
    log = folder / f"{fault.name}, {phase}.mcap".replace(" ", "-")
    folder.mkdir(parents=True, exist_ok=True)
    clock: list[float] = [0.0]
    client = free_port()
    relay = Relay(lambda: clock[0], client)
    with contextlib.ExitStack() as stack:
        stack.callback(relay.close)
        simulator = start_simulator(mission, world, choices, relay.port)
        stack.callback(simulator.close)
        troubles = Troubles(context)
        shared = simulator.shared(f"udpin://127.0.0.1:{client}")
        flight = context.Process(
            target=fly, args=(shared, mission, choices, log, troubles), daemon=True
        )
        flight.start()
        stack.callback(_end, flight)
        scene = Scene(simulator, relay, troubles, flight.pid or 0, log)
        watch = _Watch(fault, phase, mission, world, scene, clock)
        watch.run(flight)
        crashed = _crashed(flight)
        _end(flight)
    return watch.observed(crashed, *_log(log))


def _end(flight: multiprocessing.context.SpawnProcess) -> None:
    if flight.is_alive():
        flight.kill()
    flight.join(5.0)


def _crashed(flight: multiprocessing.context.SpawnProcess) -> str:
    """How it ended, when that was not by itself; empty while it runs."""
    code = flight.exitcode
    if not code:
        return ""
    if code == -signal.SIGALRM:
        return "hung and was ended by its deadman"
    return f"was ended by {signal.Signals(-code).name}" if code < 0 else "failed"


def _log(path: Path) -> tuple[float | None, str]:
    """The time of the newest record that the log gives back, or what is wrong with it."""
    try:
        times = read(path).odometry.times
    except (InputError, OSError) as error:
        return None, str(error)
    return (float(times[-1]) if len(times) else None), ""


class _Watch:
    """Looks, decides when to strike and when to stop looking."""

    def __init__(
        self, fault: Fault, phase: str, mission: Mission, world: World, scene: Scene,
        clock: list[float],
    ) -> None:  # fmt: skip
        self._fault, self._phase = fault, phase
        self._mission, self._world, self._scene, self._clock = mission, world, scene, clock
        self._samples = Samples()
        self._evidence = ""
        self._ended: float | None = None
        self._turned = False  # it was asked to come home, for the phase "return"

    def run(self, flight: multiprocessing.context.SpawnProcess) -> None:
        began, armed_at = time.monotonic(), math.inf
        clock = self._scene.simulator.clock
        while time.monotonic() < min(began + START_LIMIT, armed_at) + REAL_LIMIT:
            if math.isinf(armed_at) and self._scene.relay.heard.armed:
                armed_at = time.monotonic()
            now = clock.now()
            clock.sleep_until(now + PERIOD)
            now = self._clock[0] = clock.now()
            if self._ended is None and not flight.is_alive():
                self._ended = now
            self._look(now)
            self._strike(now)
            if self._over(now):
                return

    def _look(self, now: float) -> None:
        scene, heard, samples = self._scene, self._scene.relay.heard, self._samples
        for record in scene.simulator.truth.take():
            scene.truth = record
            samples.contact = samples.contact or record.contact
        frame = scene.simulator.camera.latest() if scene.simulator.camera else None
        if frame is not None:
            image = frame.depth_mm
            scene.frames.append(
                (frame.time, hash(image.tobytes()), bool(image.any()), float(image.std()))
            )
        if scene.truth is None:
            return
        truth = scene.truth
        poles = (*self._world.poles, *scene.appeared)
        world = World("seen", poles=poles)
        apart = clearance(world, truth.position_site[None]).obstacles[0]
        samples.rows.append(
            (now, *truth.position_site, *truth.velocity_site, float(apart), heard.setpoint_at)
        )
        samples.modes.append(heard.mode)
        samples.armed.append(heard.armed)

    def _strike(self, now: float) -> None:
        scene = self._scene
        if math.isinf(scene.since):
            if scene.truth is not None and self._reached(scene.relay.heard):
                scene.since = now
                scene.before |= self._state()
                STRIKES[self._fault.name](scene)
            return
        scene.run_due(now)
        self._evidence = self._evidence or EVIDENCE[self._fault.name](scene)

    def _state(self) -> dict[str, float]:
        truth, heard = self._scene.truth, self._scene.relay.heard
        assert truth is not None
        x, y = (float(value) for value in truth.position_site[:2])
        north, east, _ = heard.position_ned
        return {"x": x, "y": y, "north": north, "east": east, "boot": heard.boot_s}

    def _reached(self, heard: Heard) -> bool:
        """Whether the vehicle is where the fault shall strike, by truth and told mode alone."""
        truth = self._scene.truth
        assert truth is not None
        (x, y, z), speed = truth.position_site, float(np.hypot(*truth.velocity_site[:2]))
        offboard = heard.mode == "offboard"
        match self._phase:
            case "take-off":
                return heard.mode == "takeoff" and z > 1.0
            case "route":
                return offboard and 0.0 < x < fault_world.POLE_X - 4 and speed > 0.7
            case "avoidance":
                return offboard and x > 0.0 and abs(y) > 0.5
            case "landing":
                return heard.mode == "land" and z < 2.6
        if not self._turned and offboard and x > 2.0 and speed > 0.7:
            self._turned = True
            STRIKES["SIGTERM"](self._scene)
        return self._turned and offboard and truth.velocity_site[0] < -0.5

    def _over(self, now: float) -> bool:
        """Landed; or nobody flies it any more and it has been watched for long enough."""
        samples, scene = self._samples, self._scene
        if not samples.rows or (self._ended is None and math.isinf(scene.since)):
            return False
        row = samples.rows[-1]
        down = not samples.armed[-1] and row[3] < DOWN
        if math.isinf(scene.since):
            return True  # the flight is over, and the phase was never reached
        waited = now - scene.since
        if self._fault.reaction(self._phase) in (Reaction.QUIET, Reaction.DEAD):
            return waited > AFTER
        if down and not scene.later:
            return self._ended is not None or waited > AFTER
        still = float(np.hypot(row[4], row[5])) < STILL and samples.modes[-1] == "hold"
        gone = self._ended is not None and now - self._ended > AFTER
        return gone and still and not scene.later

    def observed(self, crashed: str, log_until: float | None, log_fault: str) -> Observed:
        """All of it."""
        samples, scene = self._samples, self._scene
        rows = np.array(samples.rows).reshape(-1, 9)
        return Observed(
            times=rows[:, 0],
            positions_site=rows[:, 1:4],
            velocities_site=rows[:, 4:7],
            distances=rows[:, 7],
            modes=tuple(samples.modes),
            armed=tuple(samples.armed),
            setpoints_at=rows[:, 8],
            injected=None if math.isinf(scene.since) else scene.since,
            evidence=self._evidence,
            contact=samples.contact,
            asked=tuple(scene.relay.heard.asked),
            ended=self._ended,
            crashed=crashed,
            log_until=log_until,
            log_fault=log_fault,
            takeoff_site=self._mission.takeoff_site,
            landing_site=self._mission.landing_site,
        )
