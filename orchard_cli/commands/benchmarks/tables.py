"""The tables of `orchard bench` for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.table import Table

from .peers import EGO, EGO_REPLANS, STAGES

HEADS = ("n", "median", "p95", "p99", "max")


def show(document: Mapping[str, Any]) -> None:
    """Stages, replans, the ratios to an older bench, and what it was measured on; on stdout."""
    console = Console()
    console.print(_stages(document["stages"], document["wall"]))
    console.print(_beside(document["stages"]))
    for system, fields in document["replanning"].items():
        console.print(_replans(system, fields))
    console.print(_nearness(document["replanning"]))
    if "ratios" in document:
        console.print(_ratios(document["ratios"]))
    jitter = document["setpoint_jitter"]
    console.print(
        "setpoints at 50 Hz beside full frames at 15 Hz, wall time: intervals off by "
        f"{jitter['median_ms']:.2f} ms (p99 {jitter['p99_ms']:.2f}, most {jitter['max_ms']:.2f})",
        highlight=False,
    )
    lockstep = document["lockstep"]
    console.print(
        f"lockstep: {lockstep['factor']:.1f} simulated seconds in a second of CPU, "
        f"over {lockstep['simulated_s']:.0f} s; a row of the table is one simulated second",
        highlight=False,
    )
    for key, value in document["machine"].items():
        console.print(f"  {key}: {value}", style="dim", highlight=False)


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    for i, column in enumerate(columns):
        table.add_column(column, justify="right" if i else "left")
    return table


def _ms(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


def _figures(spread: Mapping[str, Any]) -> list[str]:
    return [str(spread["n"]), *(_ms(spread[f"{head}_ms"]) for head in HEADS[1:])]


def _stages(stages: Mapping[str, Any], wall: Mapping[str, Any]) -> Table:
    table = _table("Stages, ms of CPU", "stage", *HEADS, "wall median", "wall p99")
    for name, found in stages.items():
        beside = wall.get(name, {})
        walls = (_ms(beside.get("median_ms")), _ms(beside.get("p99_ms")))
        table.add_row(name, *_figures(found), *walls)
    return table


def _beside(stages: Mapping[str, Any]) -> Table:
    table = _table("Beside others, ms", "stage", "median", "p99", "theirs", "theirs p99")
    table.add_column("who")
    for name, peers in STAGES.items():
        for peer in peers if name in stages else ():
            found = stages[name]
            ours = (_ms(found["median_ms"]), _ms(found["p99_ms"]))
            table.add_row(name, *ours, peer.median, peer.p99, peer.who)
    return table


def _replans(system: str, fields: Mapping[str, Any]) -> Table:
    columns = ("first call", "clearance m", "height m")
    title = f"Replans of {system} in a known map, ms of CPU; least clearance, worst height error"
    table = _table(title, "field", *HEADS, *columns)
    for name, found in fields.items():
        if found["replan"] is not None:
            clearance, height = _ms(found["clearance_min_m"]), _ms(found["height_error_max_m"])
            share = f"{found['first_call_share']:.1%}"
            table.add_row(name, *_figures(found["replan"]), share, clearance, height)
        for peer in EGO_REPLANS[name]:
            theirs = ("", *map(_ms, peer.spread), f"{peer.first_call_share:.1%}")
            table.add_row(f"  {EGO}, {peer.which}", *theirs, style="dim")
    return table


def _nearness(replanning: Mapping[str, Any]) -> Table:
    """First calls that succeed, by how far ahead the forced pole stands."""
    rows = [
        (f"{system}, {name}", found["first_call_by_distance_m"])
        for system, fields in replanning.items()
        for name, found in fields.items()
        if found["first_call_by_distance_m"]
    ]
    bins = sorted({distance for _, shares in rows for distance in shares})
    table = _table("First call, by metres to the forced pole", "from", *bins)
    for name, shares in rows:
        table.add_row(name, *(f"{shares[b]:.0%}" if b in shares else "" for b in bins))
    return table


def _ratios(ratios: Mapping[str, Mapping[str, float]]) -> Table:
    table = _table("New over old, below 1 is faster", "what", *HEADS[1:])
    for name, figures in ratios.items():
        row = (figures.get(f"{head}_ms") for head in HEADS[1:])
        table.add_row(name, *(_ms(value) for value in row))
    return table
