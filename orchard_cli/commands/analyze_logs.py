"""Log files -> measured flights: plugs the log, the mission, the world and analysis together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from orchard_cli.errors import Fault, InputError

if TYPE_CHECKING:
    from orchard_cli.analysis import Clearances, Flight, Unknown
    from orchard_cli.model.flown import FlownLog
    from orchard_cli.model.mission import Mission
    from orchard_cli.model.world import World

Faults = tuple[Fault, ...]


def read_all(
    paths: Sequence[Path], maps: bool = False
) -> tuple[list[Flight], list[tuple[Path, Faults]]]:
    """Every log that can be measured, and the faults of those that cannot."""
    flights, faults = [], []
    for path in paths:
        try:
            flights.append(measured(path, maps))
        except InputError as error:
            faults.append((path, error.faults))
    return flights, faults


def measured(path: Path, maps: bool = False) -> Flight:
    """Read and measure one log; `maps`: keep the maps of simulated flights as well.

    Raises InputError when it holds no flight or no mission.
    """
    from orchard_cli import mission as missions
    from orchard_cli.analysis import Flight, measure
    from orchard_cli.analysis.verdicts import verdicts
    from orchard_cli.flightlog import read

    log = read(path)
    attached = log.attachments.get("mission.json")
    if attached is None:
        raise InputError(Fault(str(path), "holds no mission", "it was cut off before the flight"))
    mission = missions.loads(attached, f"{path}: mission.json")
    world = _world(log, mission, path)
    if maps or world is None:
        log = replace(log, maps=read(path, topics=["/map/occupied"]).maps)
    clearances = _clearances(log, world)
    metrics = measure(log, mission, clearances)
    return Flight(log, mission, world, clearances, metrics, verdicts(metrics, mission))


def _world(log: FlownLog, mission: Mission, path: Path) -> World | None:
    """What the simulator flew in: the attached file, else the survey's own things."""
    from orchard_cli.simulator.world_file import from_orchard, parse

    if log.metadata.get("simulated") != "yes":
        return None
    attached = log.attachments.get("world.toml")
    if attached is None:
        return from_orchard(mission.orchard)
    return parse(attached.decode(errors="replace"), f"{path}: world.toml", mission.orchard)


def _clearances(log: FlownLog, world: World | None) -> Clearances | Unknown:
    from orchard_cli.analysis import Clearances, Unknown
    from orchard_cli.geometry.clearance import clearance

    if world is None:
        return Unknown("a real flight: the world is not known")
    if log.truth is None:
        return Unknown("the log holds no true path")
    found = clearance(world, log.truth.positions_site, log.truth.times)
    return Clearances(log.truth.times, found.obstacles, found.trees)
