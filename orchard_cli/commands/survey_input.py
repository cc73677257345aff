"""The options of a drawn survey, and showing what was recognised, for `plan` and `survey`."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchard_cli.errors import Fault, InputError

if TYPE_CHECKING:
    from rich.console import Console

    from orchard_cli.survey import Given, Survey

SurveyFile = Annotated[
    Path, typer.Argument(help="Survey: TOML, CSV, GeoJSON (.geojson, .json), KML or KMZ.")
]
TerrainFile = Annotated[
    Path | None, typer.Option("--terrain", help="GeoTIFF of the ground's height (DTM).")
]
TreeHeight = Annotated[
    float | None, typer.Option("--tree-height", help="m, of trees that tell none.")
]
TreeGap = Annotated[
    float | None, typer.Option("--tree-gap", help="m, between trees on rows drawn as lines.")
]
GroundHeight = Annotated[
    float | None, typer.Option("--ground-height", help="m above sea level, at the first tree.")
]
Heading = Annotated[
    float | None, typer.Option("--heading", help="Compass heading along the rows, degrees.")
]
FlightHeight = Annotated[
    float | None, typer.Option("--flight-height", help="m above ground, for a drawn survey.")
]
Block = Annotated[int | None, typer.Option("--block", help="Which block of trees, from 1.")]
Settings = Annotated[
    Path | None,
    typer.Option("--settings", help="TOML with what a drawing lacks: [site] [trees] [flight] ..."),
]
Yes = Annotated[bool, typer.Option("--yes", help="Take the rows that were found; ask nothing.")]

_LARGEST_SETTINGS = 100_000  # bytes
_TREES_SHOWN = 100_000
_ROOM = 5.0  # m beyond the turns for which the terrain has to tell the ground
_WIDTH, _HEIGHT = 72, 14  # characters of the picture


def given_from(
    tree_height: float | None,
    tree_gap: float | None,
    ground_height: float | None,
    heading: float | None,
    flight_height: float | None,
    block: int | None,
    settings: Path | None,
) -> Given:
    """The options as the survey room's noun."""
    from orchard_cli.model.input_text import decoded, parse_toml, read_bounded
    from orchard_cli.survey import Given

    tables: dict[str, Any] = {}
    if settings is not None:
        text = decoded(read_bounded(settings, _LARGEST_SETTINGS), settings.name)
        tables = parse_toml(text, settings.name)
    return Given(
        tree_height, tree_gap, ground_height, heading, flight_height, block, settings=tables
    )


def on_terrain(survey: Survey, path: Path) -> Survey:
    """The survey with the ground of a GeoTIFF wherever its flight may go."""
    import numpy as np

    from orchard_cli.mission.route import run_up
    from orchard_cli.survey import on_terrain as put

    wishes = survey.wishes
    ends = [p for p in (wishes.takeoff_site, wishes.landing_site) if p is not None]
    margin = run_up(wishes.limits) + wishes.headland + 2 * wishes.turn_radius + _ROOM
    return put(survey, path, margin, np.array(ends).reshape(-1, 2))


def confirm(survey: Survey, yes: bool, quiet: bool, ask: Callable[[], bool] | None = None) -> None:
    """Show rows that were found from bare positions, and ask whether they are right.

    Taken unasked with `yes` and where stdin is no terminal. Raises InputError when they are not to
    be trusted, and when the answer is no.
    """
    from rich.console import Console

    recognised = survey.recognised
    found = recognised.found if recognised else None
    if found is None:
        return
    asked = not yes and sys.stdin is not None and sys.stdin.isatty()
    if not quiet or asked or found.why_not:
        show(survey, Console(stderr=True))
    if found.why_not:
        mend = "draw the rows as lines, give each tree its row, or give --heading"
        raise InputError(
            Fault(survey.file, f"the rows are not sure: {why}", mend) for why in found.why_not
        )
    if asked and not (ask or _ask)():
        raise InputError(
            Fault(survey.file, "the rows that were found are not right",
                  "draw the rows as lines, or give each tree its row")
        )  # fmt: skip


def _ask() -> bool:
    return typer.confirm("Are these the rows?", err=True)


def show(survey: Survey, console: Console) -> None:
    """What a survey says: rows in a table, a picture, and what was recognised."""
    from rich.markup import escape
    from rich.text import Text

    console.print(Text(survey.orchard.name, style="bold"))
    recognised = survey.recognised
    if recognised:
        console.print(f"rows {recognised.how}", highlight=False)
        if recognised.found:
            console.print(_figures(survey), highlight=False)
    console.print(_table(survey))
    console.print(Text(picture(survey)))
    for note in recognised.notes if recognised else ():
        console.print(f"note: {escape(note)}", highlight=False)


def _figures(survey: Survey) -> str:
    found = survey.recognised.found if survey.recognised else None
    if found is None:
        return ""
    return (
        f"{len(found.rows)} rows, {found.spacing:.1f} m apart; trees scatter by "
        f"{found.scatter:.1f} m; about {found.doubt:.0%} of them may be in a wrong row"
    )


def _table(survey: Survey) -> Any:
    import numpy as np
    from rich.table import Table

    table = Table("row", "trees", "length m", "gaps m", "from row before m", "height m")
    before = None
    for k, row in enumerate(survey.orchard.rows, 1):
        gaps = np.hypot(*np.diff(row.trunks_site, axis=0).T)
        middle = float(np.mean(row.trunks_site[:, 1]))
        table.add_row(
            str(k), str(len(row.heights)), f"{gaps.sum():.1f}",
            f"{gaps.min():.1f} .. {gaps.max():.1f}",
            "" if before is None else f"{middle - before:.1f}",
            _range(float(row.heights.min()), float(row.heights.max())),
        )  # fmt: skip
        before = middle
        if k == 60 and len(survey.orchard.rows) > 61:
            table.add_row("...", *[""] * 5)
            break
    return table


def _range(low: float, top: float) -> str:
    return f"{low:.1f}" if low == top else f"{low:.1f} .. {top:.1f}"


def picture(survey: Survey) -> str:
    """The orchard from above in characters: x to the right, y up; rows as digits and letters."""
    import numpy as np

    orchard = survey.orchard
    rings = [r for r in (orchard.fence_site, *orchard.keep_outs_site) if len(r)]
    places = np.concatenate([row.trunks_site for row in orchard.rows] + rings)
    low, top = places.min(axis=0), places.max(axis=0)
    scale = max((top[0] - low[0]) / (_WIDTH - 1), (top[1] - low[1]) / (2 * (_HEIGHT - 1)), 0.05)
    height = int((top[1] - low[1]) / (2 * scale)) + 1
    cells = [[" "] * _WIDTH for _ in range(height)]

    def put(points: Any, mark: str) -> None:
        columns = ((points[:, 0] - low[0]) / scale).astype(int)
        lines = ((points[:, 1] - low[1]) / (2 * scale)).astype(int)
        for column, line in zip(columns[:_TREES_SHOWN], lines[:_TREES_SHOWN], strict=True):
            if 0 <= column < _WIDTH and 0 <= line < height:
                cells[height - 1 - line][column] = mark

    for ring in rings:
        put(_outline(ring), ".")
    for obstacle in orchard.obstacles:
        put(obstacle.position_site[None], "#")
    marks = "123456789abcdefghijklmnopqrstuvwxyz"
    for k, row in enumerate(orchard.rows):
        put(row.trunks_site, marks[k % len(marks)])
    heading = np.degrees(orchard.origin.heading) % 360
    lines = ["".join(line).rstrip() for line in cells]
    return "\n".join([*lines, f"--> x, heading {heading:.1f}°; {scale:.2g} m a character"])


def _outline(ring: Any) -> Any:
    import numpy as np

    closed = np.concatenate([ring, ring[:1]])
    at = np.linspace(0, len(ring), 400)
    return np.column_stack([np.interp(at, np.arange(len(closed)), axis) for axis in closed.T])
