"""Log files -> measured flights: plugs the log, the mission, the world and analysis together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from orchard_cli.errors import Fault, InputError

if TYPE_CHECKING:
    from orchard_cli.analysis import Clearances, Flight, Unknown
    from orchard_cli.model.flown import FlownLog
    from orchard_cli.model.mission import Mission
    from orchard_cli.model.world import World

Faults = tuple[Fault, ...]


@dataclass(frozen=True, slots=True)
class Ways:
    """How logs are to be read."""

    maps: bool = False  # keep the maps of simulated flights as well
    mission: Path | None = None  # the planned route, where a log does not hold it
    topic: str | None = None  # of a ROS 2 bag
    east_north_up: bool = False  # its frame; else the site frame


def read_all(
    paths: Sequence[Path], ways: Ways = Ways()
) -> tuple[list[Flight], list[tuple[Path, Faults]]]:
    """Every log that can be measured, and the faults of those that cannot."""
    flights, faults = [], []
    for path in paths:
        try:
            flights.append(measured(path, ways))
        except InputError as error:
            faults.append((path, error.faults))
    return flights, faults


def measured(path: Path, ways: Ways = Ways()) -> Flight:
    """Read and measure one log. Raises InputError when it holds no flight or no mission."""
    from orchard_cli.analysis import Flight, measure
    from orchard_cli.analysis.verdicts import verdicts
    from orchard_cli.flightlog import read

    log, mission = _read(path, ways)
    world = _world(log, mission, path)
    real = log.metadata.get("simulated") == "no"
    if real or (ways.maps and log.attachments):
        log = replace(log, maps=read(path, topics=["/map/occupied"]).maps)
    clearances = _clearances(log, world)
    metrics = measure(log, mission, clearances)
    return Flight(log, mission, world, clearances, metrics, verdicts(metrics, mission))


def mission_of(log: FlownLog, path: Path) -> Mission:
    """The mission that a log of ours holds. Raises InputError when it holds none."""
    from orchard_cli import mission as missions

    attached = log.attachments.get("mission.json")
    if attached is None:
        what = "holds no mission"
        raise InputError(Fault(str(path), what, "it was cut off early; analyze takes --mission"))
    return missions.loads(attached, f"{path}: mission.json")


def _read(path: Path, ways: Ways) -> tuple[FlownLog, Mission]:
    """The log, whoever wrote it, and the mission that it was to fly."""
    from orchard_cli import mission as missions
    from orchard_cli.flightlog import read
    from orchard_cli.flightlog.foreign.kinds import Kind, kind_of

    kind = kind_of(path)
    given = None if ways.mission is None else missions.load(ways.mission)
    if kind is Kind.OURS:
        log = read(path)
        return log, given or mission_of(log, path)
    if given is None:
        what = f"is a {kind.value} log, which holds no mission"
        raise InputError(Fault(str(path), what, "name the planned route with --mission"))
    if kind is Kind.ULOG:
        from orchard_cli.flightlog.foreign.ulog import read_ulog

        return read_ulog(path, given), given
    from orchard_cli.flightlog.foreign.ros import read_ros

    heading = given.orchard.origin.heading if ways.east_north_up else None
    return read_ros(path, ways.topic, heading), given


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
        foreign = log.metadata.get("simulated") == "unknown"
        who = f"a {log.system} log" if foreign else "a real flight"
        return Unknown(f"{who}: the world is not known")
    if log.truth is None:
        return Unknown("the log holds no true path")
    found = clearance(world, log.truth.positions_site, log.truth.times)
    return Clearances(log.truth.times, found.obstacles, found.trees)
