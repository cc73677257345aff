"""`orchard doctor`: is this computer, and what is plugged into it, fit to fly?"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchard_cli.errors import LinkError

if TYPE_CHECKING:
    from .checkups.finding import Finding


def doctor(
    connect: Annotated[
        str | None, typer.Option(help="Look at the autopilot on this MAVSDK URL, too.")
    ] = None,
    height: Annotated[
        float,
        typer.Option(min=0.5, max=200, help="Flight height, m: a return may not climb higher."),
    ] = 3.5,
    folder: Annotated[Path, typer.Option(help="Where logs will be written.")] = Path(),
    system: Annotated[
        str, typer.Option(help="Avoidance system whose kernels are compiled or loaded.")
    ] = "guided",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing.")] = False,
) -> None:
    """Look at Python, libraries, kernels, disk, clock, ports, camera and autopilot; fly nothing."""
    from .checkups.finding import Verdict

    if not folder.is_dir():
        from orchard_cli.errors import Fault, InputError

        raise InputError(Fault("--folder", f"{folder} is no folder", "name one that exists"))
    findings = _look(connect, height, folder, system)
    if as_json:
        typer.echo(json.dumps(document(findings)))
    elif not quiet:
        _show(findings)
    bad = [one for one in findings if one.verdict is Verdict.BAD]
    if bad:
        raise LinkError(f"{len(bad)} to mend before flying: {', '.join(f.item for f in bad)}")


def _look(connect: str | None, height: float, folder: Path, system: str) -> list[Finding]:
    from .checkups.camera import camera
    from .checkups.kernels import kernels
    from .checkups.link import link
    from .checkups.machine import machine
    from .checkups.software import software

    found = [*software(), *kernels(system), *machine(folder), *camera(connect is not None)]
    if connect is not None:
        found += link(connect, height)
    return found


def document(findings: list[Finding]) -> dict[str, Any]:
    """The findings for scripts."""
    return {
        "schema": "orchard-doctor/1",
        "findings": [
            {"subject": f.subject, "item": f.item, "found": f.found,
             "verdict": f.verdict.value, "mend": f.mend}
            for f in findings
        ],
    }  # fmt: skip


def _show(findings: list[Finding]) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from .checkups.finding import Verdict

    looks = {Verdict.OK: ("ok", "green"), Verdict.NOTE: ("note", "yellow"),
             Verdict.BAD: ("BAD", "bold red")}  # fmt: skip
    table = Table(box=None, pad_edge=False)
    for head in ("", "what", "found", "mend"):
        table.add_column(head, overflow="fold")
    subject = ""
    for one in findings:
        if one.subject != subject:
            subject = one.subject
            table.add_row("", Text(subject, style="bold"), "", "")
        word, style = looks[one.verdict]
        table.add_row(Text(word, style=style), Text(one.item), Text(one.found), Text(one.mend))
    Console().print(table)
