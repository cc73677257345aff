"""Durations, and how they are told: median, p95, p99 and the worst."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter_ns, thread_time_ns

import numpy as np


@dataclass(frozen=True, slots=True)
class Spread:
    """How n durations are spread, ms."""

    n: int
    median_ms: float
    p95_ms: float
    p99_ms: float
    max_ms: float

    @classmethod
    def of(cls, durations_ms: Sequence[float]) -> Spread:
        """Raises ValueError when there are none: a stage that was not measured has no figures."""
        if not durations_ms:
            raise ValueError("no durations to tell of")
        median, p95, p99, most = np.percentile(durations_ms, [50, 95, 99, 100]).tolist()
        return cls(len(durations_ms), median, p95, p99, most)


class Samples:
    """Collects durations by stage: CPU time of the calling thread, and wall time beside it."""

    def __init__(self) -> None:
        self.cpu_ms: dict[str, list[float]] = defaultdict(list)
        self.wall_ms: dict[str, list[float]] = defaultdict(list)

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Time what happens inside, once; nothing is kept when it raises."""
        wall, cpu = perf_counter_ns(), thread_time_ns()
        yield
        cpu, wall = thread_time_ns() - cpu, perf_counter_ns() - wall
        self.cpu_ms[stage].append(cpu / 1e6)
        self.wall_ms[stage].append(wall / 1e6)

    def add_cpu(self, stages_ms: Mapping[str, float]) -> None:
        """Durations that were measured elsewhere, by the CPU's clock."""
        for stage, duration in stages_ms.items():
            self.cpu_ms[stage].append(duration)


def spreads(durations: Mapping[str, Sequence[float]]) -> dict[str, Spread]:
    """The spread of every stage."""
    return {stage: Spread.of(values) for stage, values in durations.items()}
