"""`orchard analyze LOG...`: metrics of flights, side by side and beside the papers' figures."""

from __future__ import annotations

import json as json_module
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchard_cli.errors import Fault, InputError

if TYPE_CHECKING:
    from orchard_cli.analysis import Clearances, Metrics, Unknown
    from orchard_cli.analysis.paper import Published
    from orchard_cli.analysis.verdicts import Verdict
    from orchard_cli.model.flown import FlownLog
    from orchard_cli.model.mission import Mission
    from orchard_cli.model.world import World

SCHEMA = "orchard-analyze/1"


@dataclass(frozen=True, slots=True, eq=False)
class Analyzed:
    """One log, measured."""

    log: FlownLog
    mission: Mission
    world: World | None  # None: a real flight
    metrics: Metrics
    verdicts: tuple[Verdict, ...]


def analyze(
    logs: Annotated[list[Path], typer.Argument(help="Logs of `orchard fly`.")],
    json: Annotated[bool, typer.Option("--json", help="One JSON document on stdout.")] = False,
    picture: Annotated[
        Path | None, typer.Option(help="Draw the flights to this .png, .svg or .pdf.")
    ] = None,
    paper: Annotated[
        str, typer.Option(help="Published figures beside: liu2024-table1, -table2, none or auto.")
    ] = "auto",
) -> None:
    """Measure flights from their logs, and compare them."""
    results, faults = read_all(logs)
    references = published(paper, results)
    if json:
        typer.echo(json_module.dumps(document(results, faults), indent=2, allow_nan=False))
    elif results:
        from .analyze_table import show

        show(results, references)
    if picture is not None and results:
        draw(picture, results)
    if faults:
        raise InputError([fault for _, found in faults for fault in found])


def read_all(
    paths: Sequence[Path],
) -> tuple[list[Analyzed], list[tuple[Path, tuple[Fault, ...]]]]:
    """Every log that can be measured, and the faults of those that cannot."""
    results, faults = [], []
    for path in paths:
        try:
            results.append(measured(path))
        except InputError as error:
            faults.append((path, error.faults))
    return results, faults


def measured(path: Path) -> Analyzed:
    """Read and measure one log. Raises InputError when it holds no flight or no mission."""
    from dataclasses import replace

    from orchard_cli import mission as missions
    from orchard_cli.analysis import measure
    from orchard_cli.analysis.verdicts import verdicts
    from orchard_cli.flightlog import read

    log = read(path)
    attached = log.attachments.get("mission.json")
    if attached is None:
        raise InputError(Fault(str(path), "holds no mission", "it was cut off before the flight"))
    mission = missions.loads(attached, f"{path}: mission.json")
    world = _world(log, mission, path)
    if world is None:
        log = replace(log, maps=read(path, topics=["/map/occupied"]).maps)
    metrics = measure(log, mission, _clearances(log, world))
    return Analyzed(log, mission, world, metrics, verdicts(metrics, mission))


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


def published(paper: str, results: Sequence[Analyzed]) -> tuple[Published, ...]:
    """The reference columns. Raises InputError for a paper that is not there."""
    from orchard_cli.analysis.paper import FLOWN_IN, PUBLISHED

    if paper == "auto":
        fitting = {FLOWN_IN.get(r.mission.orchard.name, "none") for r in results}
        paper = fitting.pop() if len(fitting) == 1 else "none"
    if paper == "none":
        return ()
    if paper not in PUBLISHED:
        known = ", ".join((*PUBLISHED, "none", "auto"))
        raise InputError(Fault("--paper", f"no figures named {paper!r}", f"use one of {known}"))
    return PUBLISHED[paper]


def document(
    results: Sequence[Analyzed], faults: Sequence[tuple[Path, tuple[Fault, ...]]] = ()
) -> dict[str, Any]:
    """The JSON document: what is not known is null, and `unknown` says why."""
    logs = [_entry(result) for result in results]
    logs += [{"file": path.name, "error": [str(f) for f in found]} for path, found in faults]
    return {"schema": SCHEMA, "logs": logs}


def _entry(result: Analyzed) -> dict[str, Any]:
    from orchard_cli.analysis import Unknown

    def number(figure: float | Unknown) -> float | None:
        return None if isinstance(figure, Unknown) else figure

    figures = result.metrics.figures
    return {
        "file": result.log.file,
        "system": result.log.system,
        "metrics": {name: number(figure) for name, figure in figures.items()},
        "unknown": {n: f.why for n, f in figures.items() if isinstance(f, Unknown)},
        "avoidances": [
            {
                "start_s": one.start,
                "end_s": one.end,
                "peak_m": one.peak_m,
                "peak_site_m": [float(v) for v in one.peak_site],
                "altitude_drop_m": one.altitude_drop_m,
                "clearance_min_m": number(one.clearance_min_m),
            }
            for one in result.metrics.avoidances
        ],
        "verdicts": [
            {
                "metric": one.metric,
                "rule": one.rule,
                "limit": one.limit,
                "found": number(one.found),
                "found_text": one.found_text,
                "kept": one.kept,
            }
            for one in result.verdicts
        ],
        "notes": list(result.metrics.notes),
    }


def draw(path: Path, results: Sequence[Analyzed]) -> None:
    """The overview picture of all flights over the first one's orchard."""
    from orchard_cli.analysis.overview import Flight, save
    from orchard_cli.simulator.world_file import from_orchard

    first = results[0]
    world = first.world if first.world is not None else from_orchard(first.mission.orchard)
    flights = [
        Flight(name if name == result.log.system else f"{name}: {result.log.file}",
               result.log, result.metrics)
        for name, result in zip(names(results), results, strict=True)
    ]  # fmt: skip
    save(path, first.mission, flights, world.poles)


def names(results: Sequence[Analyzed]) -> list[str]:
    """A short name for each flight: its system, numbered where systems repeat."""
    systems = [result.log.system for result in results]
    return [
        system if systems.count(system) == 1 else f"{system} {systems[:i].count(system) + 1}"
        for i, system in enumerate(systems)
    ]
