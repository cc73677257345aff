"""Faults x phases, one flight each, and what became of the vehicle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from orchard_cli.campaign.faults import FAULTS, PHASES, Fault, Observed, judge_fault
from orchard_cli.campaign.ledger import Ledger
from orchard_cli.errors import Fault as InputFault
from orchard_cli.errors import InputError

from .observer import observe

SCHEMA = "orchard.campaign.faults/1"


def chosen(fault: str | None, phase: str | None) -> list[tuple[Fault, str]]:
    """The cells of the table that are asked for. Raises InputError for names there are not."""
    if fault is not None and fault not in FAULTS:
        known = ", ".join(FAULTS)
        raise InputError(InputFault("--fault", f"no fault {fault!r}", f"choose of {known}"))
    if phase is not None and phase not in PHASES:
        known = ", ".join(PHASES)
        raise InputError(InputFault("--phase", f"no phase {phase!r}", f"choose of {known}"))
    found = [
        (one, where)
        for where in PHASES
        for one in FAULTS.values()
        if where in one.phases and fault in (None, one.name) and phase in (None, where)
    ]
    if not found:
        what = f"{fault} does not strike in {phase}"
        raise InputError(InputFault("--phase", what, "leave it out"))
    return found


def run(cells: Sequence[tuple[Fault, str]], folder: Path, factor: float, quiet: bool) -> list[Any]:
    """Try what has not been tried yet; the records of all cells, in their order."""
    ledger = Ledger(folder, {"speed_factor": factor}, ("fault", "phase"))
    rest = [cell for cell in cells if (cell[0].name, cell[1]) not in ledger.records]
    for fault, phase in _counted(rest, quiet):
        ledger.add(record(fault, phase, observe(fault, phase, folder / "logs", factor)))
    return [ledger.records[fault.name, phase] for fault, phase in cells]


def _counted(rest: Sequence[tuple[Fault, str]], quiet: bool) -> Iterator[tuple[Fault, str]]:
    from rich.console import Console
    from rich.progress import track

    console = Console(stderr=True, quiet=quiet)
    yield from track(rest, "striking", console=console, transient=True)


def record(fault: Fault, phase: str, seen: Observed) -> dict[str, Any]:
    """One cell, as it is kept."""
    outcome, ok = judge_fault(fault, phase, seen)
    return {
        "fault": fault.name,
        "phase": phase,
        "happened": bool(seen.evidence),
        "evidence": seen.evidence,
        "must": fault.reaction(phase).value,
        "outcome": outcome,
        "ok": ok,
    }


def document(records: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """For scripts."""
    return {"schema": SCHEMA, "cases": list(records), "ok": all(one["ok"] for one in records)}


def timeline(seen: Observed, every: float = 0.25) -> list[tuple[str, ...]]:
    """Mode, speed, age of the setpoint and distance over time, round the moment of the fault."""
    if seen.injected is None:
        return []
    rows: list[tuple[str, ...]] = []
    last = -np.inf
    for k, moment in enumerate(seen.times):
        since = float(moment) - seen.injected
        if since < -1.0 or moment - last < every:
            continue
        last = moment
        x, y, z = seen.positions_site[k]
        speed = float(np.linalg.norm(seen.velocities_site[k]))
        age = float(moment - seen.setpoints_at[k]) if seen.setpoints_at[k] >= 0 else np.inf
        rows.append(
            (f"{since:+.2f}", seen.modes[k] if seen.armed[k] else "disarmed", f"{speed:.2f}",
             f"{age:.2f}", f"{seen.distances[k]:.2f}", f"{x:.1f} {y:.1f} {z:.1f}")
        )  # fmt: skip
    return rows
