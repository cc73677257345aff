"""What a drawing lacks and the crew gives beside it: by options, or by tables of TOML."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from orchard_cli.errors import Fault
from orchard_cli.model.site import HeightReference

from .reading import Table


@dataclass(frozen=True, slots=True)
class Given:
    """None: not given."""

    tree_height_m: float | None = None  # of trees that tell none
    tree_gap_m: float | None = None  # between the trees of a row that is drawn as a bare line
    ground_height_m: float | None = None  # above mean sea level, at the first tree
    heading_deg: float | None = None  # of the rows
    flight_height_m: float | None = None  # above ground
    block: int | None = None  # which block of trees, counted from 1
    settings: Mapping[str, Any] = field(default_factory=dict)
    """[site] (height_m, height_reference, heading_deg), [trees] (height_m, gap_m), and any table of
    a survey but its rows, which is passed on as it is."""

    @property
    def anything(self) -> bool:
        """Whether anything at all is given."""
        return self != Given()


def checked(given: Given, file: str, faults: list[Fault]) -> Given:
    """With [site] and [trees] read into the fields, where no option says otherwise.

    What remains in `settings` is passed on.
    """
    top = Table(given.settings, file, faults)
    site, trees = _with(top, given, faults)
    reference = site.choice("height_reference", HeightReference, HeightReference.AMSL)
    if "row" in given.settings:
        top.fault("row", "stands beside a drawing", "the drawing tells the rows; leave it out")
    read = replace(
        given,
        tree_height_m=_number(trees, "height_m", 0.2, 60),
        tree_gap_m=_number(trees, "gap_m", 0.5, 20),
        ground_height_m=_number(site, "height_m", -500, 9_000),
        heading_deg=_number(site, "heading_deg", -360, 360),
        settings={
            **{k: v for k, v in given.settings.items() if k not in ("site", "trees")},
            "site": {"height_reference": reference.value},
        },
    )
    site.done()
    trees.done()
    for key in ("flight", "obstacle", "keep_out"):
        wanted = dict if key == "flight" else list
        if not isinstance(given.settings.get(key, wanted()), wanted):
            top.fault(key, "is no table", f"write [{key}]" if wanted is dict else f"[[{key}]]")
    return read


def _with(top: Table, given: Given, faults: list[Fault]) -> tuple[Table, Table]:
    """[site] and [trees] with the options in their place."""
    tables = []
    for name, options in (
        ("site", {"height_m": given.ground_height_m, "heading_deg": given.heading_deg}),
        ("trees", {"height_m": given.tree_height_m, "gap_m": given.tree_gap_m}),
    ):
        top.table(name)
        told = given.settings.get(name, {})
        told = told if isinstance(told, dict) else {}
        said = {key: value for key, value in options.items() if value is not None}
        tables.append(Table({**told, **said}, f"{top.where}: {name}", faults))
    return tables[0], tables[1]


def _number(table: Table, key: str, low: float, high: float) -> float | None:
    value = table.number(key, low, high, math.nan)
    return None if math.isnan(value) else value
