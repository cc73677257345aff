"""Which papers can be reproduced, and where their tables are measured; last the grand table.

A paper's module has `TITLE` and `TABLES`: the table's key on the command line ("4", "fig13") and
the function that measures it, `(Desk) -> list[Row]`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module

from orchard_cli.errors import Fault, InputError

from .desk import Desk
from .rows import Row

PAPERS: tuple[str, ...] = (
    "liu2024", "wang2020", "huang2021", "ahmed2022", "zhou2020", "worlds",
)  # fmt: skip
ALL = "all"

Table = Callable[[Desk], list[Row]]


@dataclass(frozen=True, slots=True)
class Paper:
    """A paper's tables."""

    name: str
    title: str
    tables: Mapping[str, Table]


def papers(name: str) -> tuple[Paper, ...]:
    """The paper of that name, or all. Raises InputError when there is none."""
    if name != ALL and name not in PAPERS:
        known = ", ".join((*PAPERS, ALL))
        raise InputError(Fault("PAPER", f"no paper {name!r}", f"choose of {known}"))
    wanted = PAPERS if name == ALL else (name,)
    return tuple(_paper(one) for one in wanted)


def chosen(paper: Paper, table: str | None) -> Mapping[str, Table]:
    """All tables of a paper, or the one asked for. Raises InputError when there is none."""
    if table is None:
        return paper.tables
    key = table.lower().replace(" ", "").replace(".", "").removeprefix("table")
    if key not in paper.tables:
        known = ", ".join(paper.tables)
        raise InputError(Fault("--table", f"{paper.name} has no {table!r}", f"choose of {known}"))
    return {key: paper.tables[key]}


def _paper(name: str) -> Paper:
    module = import_module(f"{__package__}.{name}")
    return Paper(name, module.TITLE, module.TABLES)
