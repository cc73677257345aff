"""Flies one case of a campaign in lockstep and has it judged; what went wrong is kept."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from orchard_cli.campaign import Case, Judgement
    from orchard_cli.commands.wiring import Choices
    from orchard_cli.flight.safety import Request
    from orchard_cli.model.mission import Mission
    from orchard_cli.model.world import World

PATIENCE = 400.0  # s beyond three times the plan: longer than every wait of the flight rules

KEPT = ("mission.json", "world.toml", "mcap")
"""Of a flight that is looked at again."""


@dataclass(frozen=True, slots=True)
class Task:
    """One case for a worker; small, so that it travels to other machines."""

    seed: int
    number: int
    system: str
    camera: tuple[int, int]
    folder: Path
    keep: bool = False  # the log, also of a flight that went well


class Nobody:
    """Fits flight/ports.py `Operator`: asks for nothing, but ends a flight that does not end."""

    def __init__(self, now: Callable[[], float], limit: float) -> None:
        self._now = now
        self._limit = limit

    def request(self) -> Request | None:
        """A landing once the limit is over."""
        from orchard_cli.flight.safety import Request

        return Request.LAND if self._now() > self._limit else None


def fly_one(task: Task) -> dict[str, Any]:
    """Make, plan, fly and judge one case. Never raises: a bug is a result, and a failure."""
    from orchard_cli.campaign import make_case

    told = {"seed": task.seed, "case": task.number}
    try:
        case = make_case(task.seed, task.number)
        mission, world, text = prepared(case)
        found = _fly(task, case, mission, world, text, None)
        kept = task.keep or _worth_keeping(found)
        if kept:
            _keep(task, case, mission, world, text)
        return {**told, **_document(found), **_facts(case, mission), "kept": kept}
    except Exception as error:
        return {**told, **_broken(f"{type(error).__name__}: {error}")}


def prepared(case: Case) -> tuple[Mission, World, str]:
    """The mission, the world as its file is read again, and that file's text."""
    from orchard_cli.campaign import world_text
    from orchard_cli.mission import plan
    from orchard_cli.model.mission import Provenance
    from orchard_cli.simulator.world_file import parse

    made = Provenance(case.name, "0" * 64, "0", "2026-01-01T00:00:00Z")
    text = world_text(case.world)
    return plan(case.orchard, case.wishes, made), parse(text, f"{case.name}.world.toml"), text


def _fly(
    task: Task, case: Case, mission: Mission, world: World, text: str, log: Path | None
) -> Judgement:
    """`log`: where to keep one; None: nothing is written."""
    from orchard_cli.campaign import Witness, judge
    from orchard_cli.commands import wiring
    from orchard_cli.commands.conduct import conduct, run_header
    from orchard_cli.commands.loading import loaded
    from orchard_cli.commands.screen import QuietScreen
    from orchard_cli.flightlog import McapRecorder, Tee

    choices = _choices(task, case)
    mission = loaded(mission, choices)
    witness = Witness()
    kept = () if log is None else (McapRecorder(log, overwrite=True, patient=True),)
    records = Tee(witness, *kept)
    limit = 3 * mission.trajectory.end + PATIENCE
    try:
        with wiring.lockstep(mission, world, choices) as rig:
            if log is not None:
                records.write(run_header(mission, choices, rig, text.encode(), True))
            nobody = Nobody(rig.clock.now, rig.clock.now() + limit)
            ending = conduct(mission, rig, records, nobody, QuietScreen())
    finally:
        records.close()
    return judge(mission, world, witness, ending.as_planned, ending.why)


def _choices(task: Task, case: Case) -> Choices:
    from orchard_cli.commands.wiring import Choices

    return Choices(system=task.system, camera=task.camera, vehicle=case.vehicle, level=case.level)


def _keep(task: Task, case: Case, mission: Mission, world: World, text: str) -> None:
    """Fly it again, the same to the last bit, with a log."""
    from orchard_cli import mission as missions
    from orchard_cli.model.output_file import write_whole

    task.folder.mkdir(parents=True, exist_ok=True)
    files = {part: task.folder / f"{case.name}.{part}" for part in KEPT}
    missions.save(mission, files["mission.json"])
    write_whole(files["world.toml"], text)
    _fly(task, case, mission, world, text, files["mcap"])


def _worth_keeping(found: Judgement) -> bool:
    from orchard_cli.campaign import Outcome
    from orchard_cli.campaign.summary import NEAR

    return found.outcome is not Outcome.COMPLETED or found.clearance < NEAR


def _document(found: Judgement) -> dict[str, Any]:
    return {
        "outcome": found.outcome.value,
        "why": found.why,
        "contact": found.contact,
        "clearance_m": _finite(found.clearance),
        "nearest_m": {kind: _finite(metres) for kind, metres in found.nearest.items()},
        "trees_m": _finite(found.trees),
        "person_m": _finite(found.person),
        "estimate_error_m": _finite(found.error),
        "over_ideal_s": found.over_ideal and round(found.over_ideal, 2),
        "flight_s": round(found.flight, 2),
        "left_out": found.left_out,
        "holds": found.holds,
        "replans": found.replans,
    }


def _facts(case: Case, mission: Mission) -> dict[str, Any]:
    """What the case is made of, for whoever looks for what failures have in common."""
    wind = case.world.wind
    return {
        "vehicle": case.vehicle,
        "level": round(case.level, 3),
        "speed_m_s": round(mission.limits.speed, 3),
        "route_m": round(mission.route_length, 1),
        "cep_m": round(case.cep, 3),
        "wind_m_s": round(math.hypot(*wind.velocity_site[:2]), 2),
        "gust_m_s": round(wind.gust, 2),
        "slope": round(_slope(case), 3),
    }


def _slope(case: Case) -> float:
    from orchard_cli.geometry.shapes import ground_plane

    a, b, _ = ground_plane(case.world)
    return math.hypot(a, b)


def _broken(what: str) -> dict[str, Any]:
    nothing = dict.fromkeys(
        ("clearance_m", "trees_m", "person_m", "estimate_error_m", "over_ideal_s", "flight_s",
         "left_out", "holds", "replans")
    )  # fmt: skip
    return {"outcome": "unsafe end", "why": f"a bug: {what}", "contact": "", "nearest_m": {},
            **nothing, "kept": False}  # fmt: skip


def _finite(value: float) -> float | None:
    return round(value, 4) if math.isfinite(value) else None
