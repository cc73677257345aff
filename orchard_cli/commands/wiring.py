"""Plugs equipment into the flight's sockets. The one place that knows every room."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from orchard_cli.errors import LinkError
from orchard_cli.flight.boundary import area_of
from orchard_cli.flight.haven import Havens
from orchard_cli.flight.helm import Errand
from orchard_cli.flight.onboard import Onboard, OnboardJob, OnboardResult
from orchard_cli.flight.ports import Camera, Clock, Guard, Sensors, Truth, Vehicle
from orchard_cli.flight.safety import Tolerances
from orchard_cli.flight.warmup import warm_up
from orchard_cli.flight.worker import InlineWorker, ThreadWorker, Worker
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.model.depth import DepthCamera, d455
from orchard_cli.model.mission import Mission
from orchard_cli.model.tank import Load
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.model.world import World
from orchard_cli.simulator import (
    AttachedSimulator,
    LockstepSimulator,
    SimulatorProcess,
    SimulatorSettings,
)
from orchard_cli.simulator.fleet import kit
from orchard_cli.simulator.rendered_camera import RenderedCamera

from .absent import NoCamera, NoGuard
from .loading import carried
from .real_sensors import (
    await_sensors,
    demand_safe_failsafes,
    realsense,
    refuse_unknown,
)
from .systems import demand_airworthy, maker

DEADMAN = 0.5  # s of real time; a simulation that is hurried asks that much more of the computer
BLIND = Tolerances(frame_age=math.inf, planner_age=math.inf)


@dataclass(frozen=True, slots=True)
class Equipment:
    """A vehicle with its clock and its eyes, simulated or real."""

    vehicle: Vehicle
    camera: Camera
    clock: Clock
    guard: Guard
    worker: Worker[OnboardJob, OnboardResult]
    errands: Worker[Errand, Trajectory]
    tolerances: Tolerances
    truth: Truth | None
    sensors: Sensors | None
    load: Load | None
    name: str
    achieved_factor: Callable[[], float]


@dataclass(frozen=True, slots=True)
class Choices:
    """What the pilot chose on the command line."""

    system: str = "guided"
    stops: bool = False  # in every waypoint
    yaw: str | None = None  # rule of the nose: see systems.py; None: the system's own
    seed: int | None = None  # None: the world's
    speed_factor: float = 1.0
    camera: tuple[int, int] = (848, 480)
    frame_rate: float = 15.0
    mend_failsafes: bool = False
    rendered_camera: bool = False
    vehicle: str = "x500"  # simulated, or whose limits a real one has: x500 or sprayer
    level: float = 1.0  # of the tank at take-off
    detector: Path | None = None  # ONNX model with which `zones` sees; None: by depth alone
    detector_names: Path | None = None  # its class names; None: in its metadata
    logged_camera: Path | None = None  # a flight's log whose depth images the simulator's are
    return_when_empty: bool = False  # the tank; else it flies on without spraying
    serial: str = ""  # of the RealSense to use; empty: the only one
    filters: tuple[str, ...] = ()  # of the camera's vendor: "spatial", "holes"
    mount: tuple[float, float, float, float] = (0.1, 0.0, 0.0, 0.0)  # m, m, m, rad: see Mount


def onboard(mission: Mission, choices: Choices, model: DepthCamera) -> Onboard:
    """The onboard cycle with its kernels compiled or loaded. Raises InputError."""
    make = maker(choices)
    warm_up(Onboard(OccupancyGrid(), make(), mission.limits), model)
    area = area_of(mission)
    return Onboard(OccupancyGrid(), make(), mission.limits, area, Havens(mission, area))


def _tolerances(choices: Choices, sighted: bool = True) -> Tolerances:
    found = Tolerances() if sighted else BLIND
    return replace(found, empty_returns=choices.return_when_empty)


def _run(errand: Errand) -> Trajectory:
    return errand()


def _eyes(choices: Choices, camera: Camera | None, vehicle: Vehicle) -> Camera:
    """The simulator's camera, or the eyes of a logged flight. Raises InputError."""
    if choices.logged_camera is not None:
        from orchard_cli.flightlog.logged_camera import LoggedCamera, album

        return LoggedCamera(album(choices.logged_camera), vehicle.poses)
    if camera is None:
        raise LinkError("the simulator was started without a camera")
    return camera


def _start(mission: Mission) -> tuple[tuple[float, float], float]:
    """Where the simulated vehicle stands: at the take-off point, nose along the route."""
    x, y = (float(value) for value in mission.takeoff_site)
    ahead = np.asarray(mission.waypoints_site)[0, :2] - (x, y)
    return (x, y), math.atan2(float(ahead[1]), float(ahead[0]))


def _settings(mission: Mission, choices: Choices) -> SimulatorSettings:
    flown = kit(choices.vehicle, choices.level)
    return SimulatorSettings(
        seed=choices.seed,
        speed_factor=choices.speed_factor,
        port=0,  # any that is free: several simulators may fly side by side
        autopilot_port=0,
        camera=None if choices.logged_camera else choices.camera,
        frame_rate=choices.frame_rate,
        sensors=maker(choices)().needs,
        kit=flown,
        pack=flown.pack_for(mission.limits.endurance),
    )


@contextlib.contextmanager
def lockstep(mission: Mission, world: World, choices: Choices) -> Iterator[Equipment]:
    """The simulator without MAVSDK: as fast as it goes, the same bits for a seed."""
    position, yaw = _start(mission)
    simulator = LockstepSimulator(
        world,
        mission.orchard.origin,
        position,
        yaw,
        _settings(mission, choices),
        mission.takeoff_ground,
    )
    camera = _eyes(choices, simulator.camera, simulator.vehicle)
    try:
        yield Equipment(
            vehicle=simulator.vehicle,
            camera=camera,
            clock=simulator.clock,
            guard=NoGuard(),
            worker=InlineWorker(onboard(mission, choices, camera.model).cycle),
            errands=InlineWorker(_run),
            tolerances=_tolerances(choices),
            truth=simulator.truth,
            sensors=simulator.sensors,
            load=carried(mission, choices),
            name=f"simulated {kit(choices.vehicle).name} (lockstep)",
            achieved_factor=lambda: math.nan,
        )
    finally:
        simulator.vehicle.close()


def start_simulator(
    mission: Mission, world: World, choices: Choices, port: int = 0
) -> SimulatorProcess:
    """The simulated autopilot in a process of its own, which sends to `port`; 0: to any."""
    position, yaw = _start(mission)
    settings = replace(_settings(mission, choices), port=port)
    return SimulatorProcess.start(world, mission.orchard.origin, position, yaw, settings)


@contextlib.contextmanager
def simulated(mission: Mission, world: World, choices: Choices) -> Iterator[Equipment]:
    """The simulated autopilot in a process of its own, flown by MAVSDK over UDP."""
    maker(choices)  # an unknown system is told before anything is started
    with contextlib.ExitStack() as stack:
        warming = stack.enter_context(ThreadPoolExecutor(1)).submit(
            onboard, mission, choices, d455(*choices.camera)
        )
        simulator = start_simulator(mission, world, choices)
        stack.callback(simulator.close)
        yield stack.enter_context(attached(mission, choices, simulator, warming.result))


@contextlib.contextmanager
def attached(
    mission: Mission,
    choices: Choices,
    simulator: SimulatorProcess | AttachedSimulator,
    warmed: Callable[[], Onboard],
) -> Iterator[Equipment]:
    """A simulator that runs already, flown by MAVSDK over UDP."""
    from orchard_cli.vehicle import Deadman, connect

    with contextlib.ExitStack() as stack:
        vehicle = connect(
            simulator.url, mission.orchard.origin, simulator.clock.now, mission.takeoff_ground
        )
        stack.callback(vehicle.close)
        vehicle.mend_failsafes(vehicle.unsafe_failsafes(mission.highest))
        worker, errands = ThreadWorker(warmed().cycle), ThreadWorker(_run)
        stack.callback(worker.close)
        stack.callback(errands.close)
        yield Equipment(
            vehicle=vehicle,
            camera=_eyes(choices, simulator.camera, vehicle),
            clock=simulator.clock,
            guard=Deadman(DEADMAN * max(choices.speed_factor, 1.0)),
            worker=worker,
            errands=errands,
            tolerances=_tolerances(choices),
            truth=simulator.truth,
            sensors=simulator.sensors,
            load=carried(mission, choices),
            name=f"simulated {kit(choices.vehicle).name} over MAVSDK",
            achieved_factor=lambda: simulator.achieved_factor,
        )


@contextlib.contextmanager
def real(mission: Mission, url: str, choices: Choices, world: World) -> Iterator[Equipment]:
    """A real autopilot. Raises LinkError when it does not answer or its failsafes are unsafe."""
    from orchard_cli.vehicle import Deadman, MonotonicClock, connect

    sighted = choices.rendered_camera or choices.system != "none"
    needs = maker(choices)().needs
    if not choices.rendered_camera:
        demand_airworthy(choices.system, choices.yaw)
    refuse_unknown(choices.system, needs)
    clock = MonotonicClock()
    with contextlib.ExitStack() as stack:
        camera: Camera = NoCamera()
        if sighted and not choices.rendered_camera:
            camera = realsense(choices, clock.now)
            stack.callback(camera.close)
        cycle = onboard(mission, choices, camera.model).cycle
        vehicle = connect(url, mission.orchard.origin, clock.now, mission.takeoff_ground)
        stack.callback(vehicle.close)
        demand_safe_failsafes(mission, vehicle, choices.mend_failsafes)
        reach = kit(choices.vehicle).airframe.arm
        sensors = await_sensors(choices.system, needs, vehicle, reach)
        worker, errands = ThreadWorker(cycle), ThreadWorker(_run)
        stack.callback(worker.close)
        stack.callback(errands.close)
        if choices.rendered_camera:
            camera = RenderedCamera(
                world, d455(*choices.camera), choices.frame_rate, vehicle.newest_pose
            )
            stack.callback(camera.close)
        yield Equipment(
            vehicle=vehicle,
            camera=camera,
            clock=clock,
            guard=Deadman(DEADMAN),
            worker=worker,
            errands=errands,
            tolerances=_tolerances(choices, sighted),
            truth=None,
            sensors=sensors,
            load=carried(mission, choices),
            name=f"autopilot on {url}"
            + (" with a rendered camera" if choices.rendered_camera else ""),
            achieved_factor=lambda: 1.0,
        )


def load_world(mission: Mission, path: Path | None) -> tuple[World, bytes]:
    """The world to simulate and its file: `path`, or just the mission's own trees and poles."""
    from orchard_cli.simulator.world_file import from_orchard, load_with_bytes

    if path is None:
        return from_orchard(mission.orchard), b""
    return load_with_bytes(path, mission.orchard)
