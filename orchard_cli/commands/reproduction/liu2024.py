"""Liu 2024: `guided` beside the baseline, in the orchards of Tables 1 and 2, flown in lockstep."""

from __future__ import annotations

from orchard_cli.errors import Fault, InputError

from .desk import Desk
from .rows import Row

TITLE = "Liu 2024: lemon orchards, the method and EGO-Planner"
_SYSTEMS = ("guided", "ego")  # as the paper's columns: proposed, ego
_UNITS = {"_m_s2": "m/s²", "_m_s": "m/s", "_rad_s": "rad/s", "_m": "m", "_s": "s"}


def table1(desk: Desk) -> list[Row]:
    """The orchard in Gazebo."""
    return _flights(desk, "Table 1", "lemon-gazebo", "liu2024-table1")


def table2(desk: Desk) -> list[Row]:
    """The orchard in the field."""
    return _flights(desk, "Table 2", "lemon-field", "liu2024-table2")


TABLES = {"1": table1, "2": table2}


def _flights(desk: Desk, table: str, orchard: str, figures: str) -> list[Row]:
    from orchard_cli import mission as missions
    from orchard_cli.analysis.paper import PUBLISHED
    from orchard_cli.commands.demo import MISSIONS
    from orchard_cli.commands.wiring import Choices

    file, world = MISSIONS / f"{orchard}.mission.json", MISSIONS / f"{orchard}.world.toml"
    if not file.exists():
        what = "the missions/ folder of the repository is needed"
        raise InputError(Fault(str(file), what, "run it from a clone installed with pip -e"))
    mission, toml = missions.load(file), world.read_text(encoding="utf-8")
    rows = []
    for system, paper in zip(_SYSTEMS, PUBLISHED[figures], strict=True):
        choices = Choices(system=system, seed=desk.seed)
        flight = desk.fly(f"{orchard}-{system}", mission, toml, choices)
        for k, (name, value) in enumerate(paper.figures.items()):
            found = flight.metrics.figures[name]
            ours = float(found) if isinstance(found, int | float) else None
            said = "; ".join(paper.notes) if k == 0 else ""
            if ours is None:
                said = str(found)
            rows.append(Row(table, system, name, value, ours, _unit(name), said))
    return rows


def _unit(name: str) -> str:
    return next(unit for ending, unit in _UNITS.items() if name.endswith(ending))
