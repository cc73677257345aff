"""The simulator in a process of its own, running in scaled real time and speaking MAVLink."""

from __future__ import annotations

import multiprocessing
import os
import signal
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess

from orchard_cli.errors import LinkError
from orchard_cli.model.depth import DepthCamera, DepthFrame, d455
from orchard_cli.model.records import TruthRecord
from orchard_cli.model.sensors import Sensed
from orchard_cli.model.site import SiteOrigin
from orchard_cli.model.world import World

from .autopilot import TICK
from .board import Board
from .faults import LinkFault, SimulatedFault
from .mavlink import Endpoint, UdpLink
from .run import Run, mounted
from .settings import SimulatorSettings

HOST = "127.0.0.1"
SLIP = 0.05  # s of real time that may be caught up; what is later than that is lost for good
LOOK_EVERY = 25  # ticks between looks at whether the starter still lives
START_PATIENCE = 120.0  # s: compiling the kernels on a slow machine
CLOSE_PATIENCE = 2.0  # s
LONGEST_SLEEP = 0.1  # s of real time: whoever waits looks up at least this often
WARM_UP = 15  # ticks: every sensor has looked at least once


class SimulatorProcess:
    """A running simulator. Its clock, camera and truth fit the sockets in flight/ports.py."""

    def __init__(self, process: BaseProcess, pipe: Connection, board: Board, port: int,
                 factor: float) -> None:  # fmt: skip
        self._process = process
        self._pipe = pipe
        self._board = board
        self._factor = factor
        self.url = f"udpin://{HOST}:{port}"
        self.clock = SimulatedClock(board, process.is_alive, factor)
        self.camera = SimulatedCamera(board) if board.camera else None
        self.truth = SimulatedTruth(board)
        self.sensors = SimulatedSensors(board)

    @classmethod
    def start(
        cls,
        world: World,
        origin: SiteOrigin,
        start_site: tuple[float, float],
        start_yaw_site: float,
        settings: SimulatorSettings | None = None,
    ) -> SimulatorProcess:
        """Start it and wait until it runs. Raises LinkError when it cannot."""
        settings = settings or SimulatorSettings()
        port = settings.port or _free_port()
        context = multiprocessing.get_context("spawn")
        camera = d455(*settings.camera) if settings.camera else None
        board = Board(context, camera, mounted(settings), "colour" in settings.sensors)
        pipe, far = context.Pipe()
        process = context.Process(
            target=_main,
            args=(far, board, world, origin, start_site, start_yaw_site, settings, port),
            name="orchard-simulator",
            daemon=True,
        )
        process.start()
        far.close()
        handle = cls(process, pipe, board, port, settings.speed_factor)
        try:
            handle._await_start()
        except BaseException:
            handle.close()
            raise
        return handle

    def _await_start(self) -> None:
        try:
            if not self._pipe.poll(START_PATIENCE):
                raise LinkError(f"the simulator did not start within {START_PATIENCE:.0f} s")
            said = self._pipe.recv()
        except EOFError:
            raise LinkError("the simulator ended while it was starting") from None
        if said != "running":
            raise LinkError(f"the simulator cannot start: {said}")

    @property
    def achieved_factor(self) -> float:
        """Simulated seconds per real second since the start."""
        return self._board.achieved

    @property
    def pid(self) -> int | None:
        """The process's number."""
        return self._process.pid

    def shared(self, url: str = "") -> SharedSimulator:
        """What another process needs to fly in it, by `url` where that is not the simulator's."""
        return SharedSimulator(self._board, url or self.url, self._factor, self._process.pid or 0)

    def inject(self, fault: SimulatedFault) -> None:
        """Make something go wrong in the simulation, within a quarter of a simulated second."""
        self._pipe.send(fault)

    def close(self) -> None:
        """End the process, whatever it is doing. May be called again."""
        self._pipe.close()  # it ends by itself when it sees this
        self._process.join(CLOSE_PATIENCE)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


@dataclass(frozen=True, slots=True)
class SharedSimulator:
    """A running simulator, to be handed to another process as an argument of it."""

    board: Board
    url: str  # where MAVSDK shall listen
    factor: float
    pid: int


class AttachedSimulator:
    """A running simulator in a process that has not started it, and cannot end it."""

    def __init__(self, shared: SharedSimulator) -> None:
        self._board = shared.board
        self._pid = shared.pid
        self.url = shared.url
        self.clock = SimulatedClock(shared.board, self._alive, shared.factor)
        self.camera = SimulatedCamera(shared.board) if shared.board.camera else None
        self.truth = SimulatedTruth(shared.board)
        self.sensors = SimulatedSensors(shared.board)

    @property
    def achieved_factor(self) -> float:
        """Simulated seconds per real second since the start."""
        return self._board.achieved

    def _alive(self) -> bool:
        try:
            os.kill(self._pid, 0)
        except ProcessLookupError:
            return False
        return True


class SimulatedClock:
    """Simulated time. It slips when the simulator cannot keep its factor, and never jumps."""

    def __init__(self, board: Board, alive: Callable[[], bool], factor: float) -> None:
        self._board = board
        self._alive = alive
        self._factor = factor
        self._newest = 0.0

    def now(self) -> float:
        """Seconds since the simulated boot; between two ticks it runs on, by at most one tick."""
        reached, at = self._board.clock()
        since = max(0.0, time.monotonic() - at) * self._factor
        self._newest = max(self._newest, reached + min(since, TICK))
        return self._newest

    def sleep_until(self, moment: float) -> None:
        """Return at `moment` of simulated time, or after LONGEST_SLEEP of real time.

        Raises LinkError when the simulator has ended.
        """
        until = time.monotonic() + LONGEST_SLEEP
        while (wait := moment - self.now()) > 0 and time.monotonic() < until:
            if not self._alive():
                raise LinkError("the simulator has ended")
            time.sleep(min(max(wait / self._factor, 0.0002), LONGEST_SLEEP))


class SimulatedCamera:
    """Newest frame of the simulated depth camera."""

    def __init__(self, board: Board) -> None:
        assert board.camera is not None
        self.model: DepthCamera = board.camera
        self._board = board
        self._handed_out = 0

    def latest(self) -> DepthFrame | None:
        """The newest frame, once; None when it was handed out already."""
        self._handed_out, frame = self._board.frame(self._handed_out)
        return frame

    def close(self) -> None:
        """Nothing to let go of."""


class SimulatedSensors:
    """Newest scans of the simulated radar and lasers."""

    def __init__(self, board: Board) -> None:
        self._board = board

    def newest(self) -> Sensed:
        """The newest scan of each sensor."""
        return self._board.sensed()


class SimulatedTruth:
    """Where the vehicle really was, at 50 Hz."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self._taken = 0

    def take(self) -> tuple[TruthRecord, ...]:
        """Records since the last call."""
        self._taken, records = self._board.truth(self._taken)
        return records


def _free_port() -> int:
    """A UDP port that nobody uses now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])


def _main(
    pipe: Connection,
    board: Board,
    world: World,
    origin: SiteOrigin,
    start_site: tuple[float, float],
    start_yaw_site: float,
    settings: SimulatorSettings,
    port: int,
) -> None:
    """The child: build, warm up, say so, and run until the starter closes its end of the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the pilot's, who still needs us
    try:
        _warm_up(Run(world, start_site, start_yaw_site, settings))
        run = Run(world, start_site, start_yaw_site, settings)
        link = UdpLink((HOST, settings.autopilot_port), (HOST, port), (1, 1))
    except Exception as error:
        pipe.send(f"{type(error).__name__}: {error}")
        return
    endpoint = Endpoint(run.autopilot, origin, time.time())
    pipe.send("running")
    pace = _Pace(settings.speed_factor)
    for tick in range(1, 1 << 62):
        pace.wait(tick * TICK)
        for message in link.receive():
            link.send(endpoint.handle(message))
        due = run.step()
        board.set_clock(run.time)
        if due.truth is not None:
            board.put_truth(due.truth)
        if due.frame is not None:
            board.put_frame(due.frame)
        for scan in due.scans:
            board.put_scan(scan)
        link.send(endpoint.tick())
        if tick % LOOK_EVERY == 0:
            board.set_achieved(pace.achieved(run.time))
            if not _inject_all(pipe, run, endpoint):
                return


def _inject_all(pipe: Connection, run: Run, endpoint: Endpoint) -> bool:
    """Make happen what the starter asks for; False once the starter is gone."""
    try:
        while pipe.poll():
            fault: SimulatedFault = pipe.recv()
            if isinstance(fault, LinkFault):
                endpoint.inject(fault)
            else:
                run.inject(fault)
    except (EOFError, OSError):
        return False
    return True


def _warm_up(run: Run) -> None:
    """Compile or load every kernel before the clock starts: fly and look once."""
    ticks, frame = 0, None
    while ticks < WARM_UP or (frame is None and run.camera is not None):
        frame = run.step().frame or frame
        ticks += 1


class _Pace:
    """Keeps simulated time at a factor of real time, without ever hurrying after a long stall."""

    def __init__(self, factor: float) -> None:
        self._factor = factor
        self._started = self._zero = time.monotonic()

    def wait(self, moment: float) -> None:
        """Sleep until simulated `moment` is due."""
        ahead = self._zero + moment / self._factor - time.monotonic()
        if ahead > 0:
            time.sleep(ahead)
        elif ahead < -SLIP:
            self._zero -= ahead

    def achieved(self, now: float) -> float:
        """Simulated seconds per real second since the start."""
        return now / max(time.monotonic() - self._started, 1e-9)
