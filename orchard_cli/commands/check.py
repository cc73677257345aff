"""`orchard check MISSION`: every rule that a mission has to keep, judged before it flies."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchard_cli.errors import Fault, InputError

if TYPE_CHECKING:
    from orchard_cli.mission.inspection import Finding
    from orchard_cli.model.mission import Mission


def check(
    mission: Annotated[Path, typer.Argument(help="Mission file from `orchard plan`.")],
    world: Annotated[
        Path | None, typer.Option(help="World file: its trees, poles, wires and boxes count, too.")
    ] = None,
    lowest: Annotated[
        float | None,
        typer.Option("--min-height", help="Least height above ground, m. Default: the clearance."),
    ] = None,
    highest: Annotated[
        float | None,
        typer.Option("--max-height", help="Greatest height above ground, m. Default: 120."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing.")] = False,
) -> None:
    """Judge a mission as it will be flown: each rule with its figure, its limit and the place."""
    from orchard_cli import mission as missions
    from orchard_cli.mission.inspection import HIGHEST, HeightBand, inspect

    plan = missions.load_unchecked(mission)
    band = HeightBand(
        plan.limits.clearance if lowest is None else lowest,
        HIGHEST if highest is None else highest,
    )
    things = None
    if world is not None:
        from orchard_cli.simulator.world_file import load as load_world

        things = load_world(world, plan.orchard)
    findings = inspect(plan, things, band)
    broken = [finding for finding in findings if not finding.ok]
    if as_json:
        json.dump(document(plan, mission, findings), sys.stdout)
        sys.stdout.write("\n")
    elif not quiet:
        _print(plan, findings)
    if broken:
        worst = broken[0]
        raise InputError(
            Fault(
                str(mission),
                f"breaks {len(broken)} of {len(findings)} checks, first {worst.rule.name}: "
                f"{_figure(worst)}, {_limit(worst)} {worst.rule.unit}",
                "do not fly it; mend the survey and plan again",
            )
        )


def document(plan: Mission, path: Path, findings: list[Finding]) -> dict[str, Any]:
    """The findings for scripts."""
    from orchard_cli.geometry.geodesy import wgs84_from_site

    entries = []
    for f in findings:
        entry: dict[str, Any] = {
            "rule": f.rule.name,
            "ok": f.ok,
            "figure": round(f.figure, 4) if math.isfinite(f.figure) else None,
            "sense": f.rule.sense.value,
            "limit": f.rule.limit if math.isfinite(f.rule.limit) else None,
            "unit": f.rule.unit,
            "about": f.about,
        }
        if f.place_site is not None:
            place = wgs84_from_site(plan.orchard.origin, f.place_site[None])[0]
            entry["at_m"] = [round(float(v), 3) for v in f.place_site]
            entry["at_wgs84"] = [round(float(v), d) for v, d in zip(place, (8, 8, 3), strict=True)]
        if f.time is not None:
            entry["at_s"] = round(f.time, 2)
        entries.append(entry)
    broken = sum(not f.ok for f in findings)
    return {
        "mission": str(path),
        "name": plan.name,
        "ok": broken == 0,
        "checked": len(findings),
        "broken": broken,
        "height_reference": plan.orchard.origin.height_reference.value,
        "findings": entries,
    }


def _number(value: float) -> str:
    """Three decimals at most, none needlessly."""
    return f"{value + 0.0:.3f}".rstrip("0").rstrip(".").replace("-0", "0", value > -5e-4)


def _figure(finding: Finding) -> str:
    if math.isnan(finding.figure):
        return "cannot be told"
    if math.isinf(finding.figure):
        return "none near"
    return f"{_number(finding.figure)} {finding.rule.unit}"


def _limit(finding: Finding) -> str:
    if math.isinf(finding.rule.limit):
        return "no limit"
    return f"{finding.rule.sense.value} {_number(finding.rule.limit)}"


def _print(plan: Mission, findings: list[Finding]) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(plan.name), title_justify="left", box=None, pad_edge=False)
    for heading in ("", "rule", "figure", "limit", "where"):
        table.add_column(heading, overflow="fold", no_wrap=not heading)
    for f in findings:
        mark = Text("ok", "green") if f.ok else Text("BROKEN", "bold red")
        table.add_row(mark, f.rule.name, _figure(f), _limit(f), Text(_where(plan, f)))
    console = Console()
    console.print(table)
    broken = sum(not f.ok for f in findings)
    verdict = "all kept" if not broken else f"{broken} BROKEN: do not fly it"
    console.print(f"{len(findings)} checks, {verdict}", highlight=False)


def _where(plan: Mission, finding: Finding) -> str:
    """What and where: in the site frame, and on earth where the rule is broken."""
    from orchard_cli.geometry.geodesy import wgs84_from_site

    if finding.place_site is None:
        return finding.about
    x, y, z = finding.place_site
    at = "" if finding.time is None else f" at {finding.time:.1f} s"
    where = f"{finding.about} ({x:.1f}, {y:.1f}, {z:.1f}){at}".strip()
    if finding.ok:
        return where
    lat, lon, _ = wgs84_from_site(plan.orchard.origin, finding.place_site[None])[0]
    return f"{where}, {lat:.7f} {lon:.7f}"
