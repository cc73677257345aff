"""Why it turned there: what was known and decided around each avoidance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from orchard_cli.geometry.clearance import clearance
from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.flown import FlownLog
from orchard_cli.model.records import NewTrajectory, OccupiedCells, PlannerRecord
from orchard_cli.model.world import World

from .figures import Avoidance, Figure, Unknown
from .flight import Flight
from .lines import planned

T = TypeVar("T", NewTrajectory, OccupiedCells)

LEAD = 6.0  # s before the path bends in which its decision may have been taken
AROUND = 4.0  # s of the flight before the decision and after the avoidance
LAYER = 0.6  # m above and below the flight: cells that stood in the way
SETTLED = 1.5  # s after the decision in which it may be bettered: the last one is shown
MAP_WAIT = 1.2  # s: maps are logged about once a second
DRAWN = 15.0  # s of a trajectory that are shown


@dataclass(frozen=True, slots=True)
class Choice:
    """One decision of the planner, as its cycle logged it."""

    time: float  # s, flight clock
    decision: str
    why: str
    frame_age: float  # s from the depth frame's stamp to the decision
    blocked_at: float | None  # m of path ahead
    took_ms: float | None


@dataclass(frozen=True, slots=True)
class Bearing:
    """How it flew in one stretch."""

    seconds: float
    speed_m_s: float  # mean
    height_m: float  # mean, site frame
    deviation_max_m: float


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """One avoidance with everything that explains it."""

    avoidance: Avoidance
    choices: tuple[Choice, ...]
    decided: float  # s: the first of them, else the avoidance's start
    flown_site: Points  # (n, 3) m, from AROUND before to AROUND after
    old_site: Points  # (n, 3) m, the trajectory that was given up; empty: not logged
    new_site: Points  # (n, 3) m, the one that was taken instead; empty: not logged
    cells_site: Points  # (n, 2) m, occupied cells at flight height, about when it was decided
    cell: float  # m, their edge
    map_delay: float | None  # s from the decision to the map's record; negative: before it
    vehicle_site: Array  # (3,) m when it was decided
    heading: float  # rad
    passed: str  # "pole 2" and so on; empty: not known
    clearance: Figure  # m
    bearings: tuple[Bearing, Bearing, Bearing]  # before, in it, after


def turns(flight: Flight) -> tuple[Turn, ...]:
    """Each avoidance of a flight, explained as far as its log can."""
    found = []
    free = -np.inf
    for avoidance in flight.metrics.avoidances:
        found.append(_turn(flight, avoidance, max(free, avoidance.start - LEAD)))
        free = avoidance.end
    return tuple(found)


def _turn(flight: Flight, avoidance: Avoidance, since: float) -> Turn:
    log = flight.log
    choices = _choices(log, since, avoidance.end)
    decided = min((choice.time for choice in choices), default=avoidance.start)
    start, end = min(decided, avoidance.start), avoidance.end
    track = log.odometry
    here = min(int(np.searchsorted(track.times, decided)), len(track.times) - 1)
    w, x, y, z = track.site_from_body[here]
    cells = _decisive(log.maps, decided)
    taken = [one for one in log.trajectories if decided <= one.time <= decided + SETTLED]
    given_up = [one for one in log.trajectories if one.time < decided]
    return Turn(
        avoidance=avoidance,
        choices=choices,
        decided=decided,
        flown_site=track.between(start - AROUND, end + AROUND).positions_site,
        old_site=_path(given_up[-1] if given_up else None, decided),
        new_site=_path(taken[-1], taken[-1].time) if taken else np.empty((0, 3)),
        cells_site=_layer(cells, float(track.positions_site[here, 2])),
        cell=cells.cell if cells else 0.1,
        map_delay=cells.time - decided if cells else None,
        vehicle_site=track.positions_site[here],
        heading=float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))),
        passed=_passed(flight.world, log, avoidance),
        clearance=avoidance.clearance_min_m,
        bearings=(
            _bearing(flight, start - AROUND, start),
            _bearing(flight, start, end),
            _bearing(flight, end, end + AROUND),
        ),
    )


def _choices(log: FlownLog, since: float, end: float) -> tuple[Choice, ...]:
    """What was decided in a time, from the first decision that an obstacle was the reason of.

    A system that plans every metre anew also takes new curves where nothing is in the way.
    """
    made = [
        _choice(record)
        for record in log.planner
        if since <= record.time <= end and record.decision != "keep"
    ]
    begun = next((i for i, one in enumerate(made) if one.blocked_at), 0)
    return tuple(made[begun:])


def _choice(record: PlannerRecord) -> Choice:
    stages = record.stages_ms
    return Choice(
        time=record.time,
        decision=record.decision,
        why=record.why,
        frame_age=record.time - record.frame_time,
        blocked_at=record.blocked_at,
        took_ms=stages.get("cycle", stages.get("plan")),
    )


def _newest(records: tuple[T, ...], time: float) -> T | None:
    """The last record that was written up to a time."""
    older = [one for one in records if one.time <= time]
    return older[-1] if older else None


def _decisive(maps: tuple[OccupiedCells, ...], time: float) -> OccupiedCells | None:
    """The first map that holds what was decided on, if it was logged soon; else the last before."""
    later = next((one for one in maps if time <= one.time <= time + MAP_WAIT), None)
    return later or _newest(maps, time)


def _path(record: NewTrajectory | None, time: float) -> Points:
    if record is None:
        return np.empty((0, 3))
    curve = record.trajectory
    begin = min(max(time, curve.start), curve.end)
    return curve.sample(np.arange(begin, min(curve.end, begin + DRAWN) + 1e-9, 0.2))[0]


def _layer(cells: OccupiedCells | None, height: float) -> Points:
    if cells is None or not len(cells.centres_site):
        return np.empty((0, 2))
    near = np.abs(cells.centres_site[:, 2] - height) <= LAYER
    return np.unique(np.round(cells.centres_site[near, :2], 3), axis=0)


def _passed(world: World | None, log: FlownLog, avoidance: Avoidance) -> str:
    """Name of the obstacle that came nearest, counted from 1 as in the world file."""
    if world is None or log.truth is None or isinstance(avoidance.clearance_min_m, Unknown):
        return ""
    track = log.truth.between(avoidance.start, avoidance.end)
    nearest, name = np.inf, ""
    for alone, called in _alone(world):
        away = clearance(alone, track.positions_site, track.times).obstacles
        if len(away) and away.min() < nearest:
            nearest, name = float(away.min()), called
    return name


def _alone(world: World) -> Iterator[tuple[World, str]]:
    """Each obstacle in a world of its own, and its name."""
    for n, pole in enumerate(world.poles, 1):
        yield World("", poles=(pole,)), f"pole {n}"
    for n, wire in enumerate(world.wires, 1):
        yield World("", wires=(wire,)), f"wire {n}"
    for n, box in enumerate(world.boxes, 1):
        yield World("", boxes=(box,)), f"box {n}"
    for n, person in enumerate(world.people, 1):
        yield World("", people=(person,)), f"person {n}"


def _bearing(flight: Flight, start: float, end: float) -> Bearing:
    track = flight.log.odometry.between(start, end)
    if not len(track.times):
        return Bearing(0.0, np.nan, np.nan, np.nan)
    offset = planned(flight.mission).offset(track.positions_site).distance
    return Bearing(
        seconds=end - start,
        speed_m_s=float(np.linalg.norm(track.velocities_site, axis=1).mean()),
        height_m=float(track.positions_site[:, 2].mean()),
        deviation_max_m=float(offset.max()),
    )
