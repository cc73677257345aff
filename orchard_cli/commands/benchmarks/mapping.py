"""The map's stages: projecting a frame's pixels, and the whole update."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import thread_time_ns
from types import ModuleType
from typing import Any

from orchard_cli.geometry.poses import interpolate
from orchard_cli.mapping import OccupancyGrid
from orchard_cli.mapping import _kernels as mapping_kernels

from .frames import Seen, Stretch
from .samples import Samples

AIRFRAME = 0.35  # m
WARM_UP = 30  # frames
PROJECTING = ("project", "count_hits", "nearest_blocks")
"""Kernels whose work is the inverse projection (Liu 2024, eqs. 4-8) and sorting into cells."""


def measure(stretches: Sequence[Stretch], stage: str, rounds: int, samples: Samples) -> None:
    """Time the map's update over all frames, as `stage`.

    Every stretch begins with an empty map; its first frame is not counted, nor is a first walk
    through some frames, in which the kernels are compiled or loaded.
    """
    _map(stretches[0].seen[:WARM_UP], stage, Samples())
    for _ in range(rounds):
        for stretch in stretches:
            _map(stretch.seen, stage, samples)


def measure_projection(stretches: Sequence[Stretch], samples: Samples) -> None:
    """Time `project` inside the map's update, whose kernels are compiled already."""
    kernels: dict[str, list[float]] = {}
    with clocked(mapping_kernels, kernels):
        for stretch in stretches:
            _project(stretch.seen, kernels, samples)


def update(grid: OccupancyGrid, seen: Seen) -> None:
    """What the onboard cycle does with a frame."""
    pose = interpolate((seen.vehicle.pose,), seen.frame.time)
    if pose is None:
        raise ValueError("a frame without its pose")
    grid.insert(seen.frame, pose)
    grid.clear_sphere(seen.vehicle.position_site, AIRFRAME)


def _map(frames: Sequence[Seen], stage: str, samples: Samples) -> None:
    grid = OccupancyGrid()
    update(grid, frames[0])
    for seen in frames[1:]:
        with samples.timed(stage):
            update(grid, seen)


def _project(frames: Sequence[Seen], kernels: dict[str, list[float]], samples: Samples) -> None:
    grid = OccupancyGrid()
    for number, seen in enumerate(frames):
        kernels.clear()
        update(grid, seen)
        shares = [sum(kernels[name]) for name in PROJECTING if name in kernels]
        if number > 0 and shares:
            samples.add_cpu({"project": sum(shares)})


@contextmanager
def clocked(module: ModuleType, found: dict[str, list[float]]) -> Iterator[None]:
    """Time each call of a module's kernels into `found`, CPU ms by name.

    Only for kernels that are compiled already: the compiler would not know the wrappers.
    """
    kept = {
        n: k for n, k in vars(module).items() if not n.startswith("_") and hasattr(k, "py_func")
    }
    try:
        for name, kernel in kept.items():
            setattr(module, name, _timing(name, kernel, found))
        yield
    finally:
        for name, kernel in kept.items():
            setattr(module, name, kernel)


def _timing(
    name: str, kernel: Callable[..., Any], found: dict[str, list[float]]
) -> Callable[..., Any]:
    def called(*arguments: Any) -> Any:
        began = thread_time_ns()
        result = kernel(*arguments)
        found.setdefault(name, []).append((thread_time_ns() - began) / 1e6)
        return result

    return called
