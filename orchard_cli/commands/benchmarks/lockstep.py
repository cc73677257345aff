"""How fast the simulator flies without MAVSDK: CPU time per simulated second."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import ClassVar

from orchard_cli.flight.gear import Gear
from orchard_cli.flight.ports import Clock
from orchard_cli.flight.reporter import Reporter
from orchard_cli.flight.runner import Flight
from orchard_cli.model.mission import Mission
from orchard_cli.model.records import Record
from orchard_cli.model.world import World

from .. import wiring
from ..screen import QuietScreen
from .samples import Samples

WARM_UP = 20.0  # simulated s: take-off and the way to the route


@dataclass(frozen=True, slots=True)
class Pace:
    """What a flight in lockstep took."""

    simulated_s: float
    cpu_s: float
    wall_s: float

    @property
    def factor(self) -> float:
        """Simulated seconds per second of CPU time."""
        return self.simulated_s / self.cpu_s


class _Over(Exception):
    """Enough was flown."""


class _Measured:
    """A clock that notes each simulated second's cost, and ends the flight after some of them."""

    def __init__(self, clock: Clock, seconds: float, samples: Samples) -> None:
        self._clock, self._samples = clock, samples
        self._end = clock.now() + seconds
        self._next = clock.now() + 1.0
        self._cpu, self._wall = time.thread_time(), time.perf_counter()

    def now(self) -> float:
        return self._clock.now()

    def sleep_until(self, moment: float) -> None:
        self._clock.sleep_until(moment)
        if moment >= self._next:
            cpu, wall = time.thread_time(), time.perf_counter()
            self._samples.cpu_ms["lockstep"].append((cpu - self._cpu) * 1e3)
            self._samples.wall_ms["lockstep"].append((wall - self._wall) * 1e3)
            self._cpu, self._wall, self._next = cpu, wall, self._next + 1.0
        if moment >= self._end:
            raise _Over


class _Nobody:
    """Asks for nothing and writes nothing down."""

    losses: ClassVar[Mapping[str, int]] = {}

    def request(self) -> None:
        return None

    def write(self, record: Record) -> None:
        del record

    def close(self) -> None:
        pass


def measure(mission: Mission, world: World, seconds: float, samples: Samples) -> Pace:
    """Fly the first `seconds` of a mission with full frames, mapping and avoidance.

    `lockstep` is the cost of each simulated second. The log is not written; what is compiled or
    loaded is so in a shorter flight before.
    """
    _fly(mission, world, min(seconds, WARM_UP), Samples())
    _fly(mission, world, seconds, samples)
    cpu, wall = samples.cpu_ms["lockstep"], samples.wall_ms["lockstep"]
    return Pace(float(len(cpu)), sum(cpu) / 1e3, sum(wall) / 1e3)


def _fly(mission: Mission, world: World, seconds: float, samples: Samples) -> None:
    with wiring.lockstep(mission, world, wiring.Choices()) as equipment:
        clock, nobody = _Measured(equipment.clock, seconds, samples), _Nobody()
        plugged = {
            socket.name: getattr(equipment, socket.name)
            for socket in fields(Gear)
            if hasattr(equipment, socket.name)
        }
        reporter = Reporter(mission, nobody, QuietScreen(), clock.now())
        ours = {"clock": clock, "recorder": nobody, "reporter": reporter, "operator": nobody}
        with contextlib.suppress(_Over):
            Flight(mission, Gear(**{**plugged, **ours}), equipment.tolerances).run()
