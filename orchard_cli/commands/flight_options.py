"""`orchard plan`'s options for how to fly: each stands in for a key of the survey's [flight]."""

from __future__ import annotations

from typing import Annotated, Any

import typer

Height = Annotated[float | None, typer.Option("--height", help="Flight height, m.")]
HeightAbove = Annotated[
    str | None, typer.Option("--height-above", help="ground or canopy: what --height counts from.")
]
Follow = Annotated[
    str | None, typer.Option("--follow", help="line or terrain: straight over a row, or with it.")
]
Speed = Annotated[float | None, typer.Option("--speed", help="Greatest speed, m/s.")]
Swath = Annotated[float | None, typer.Option("--swath", help="Width that one pass treats, m.")]
Overlap = Annotated[
    float | None, typer.Option("--overlap", help="Share of the swath; as many passes as it takes.")
]
Passes = Annotated[int | None, typer.Option("--passes", help="Passes for each row.")]
FlyOver = Annotated[str | None, typer.Option("--fly-over", help="rows, or between them.")]
Pattern = Annotated[
    str | None, typer.Option("--pattern", help="every, out_and_back or alternate (every second).")
]
Direction = Annotated[
    str | None, typer.Option("--direction", help="both ways in turn, or one_way.")
]
StartRow = Annotated[str | None, typer.Option("--start-row", help="first or last.")]
StartSide = Annotated[str | None, typer.Option("--start-side", help="near or far.")]
Turn = Annotated[str | None, typer.Option("--turn", help="square, rounded or loop.")]
Headland = Annotated[
    float | None, typer.Option("--headland", help="m beyond the last trees where turns begin.")
]
TurnRadius = Annotated[float | None, typer.Option("--turn-radius", help="m, of a loop.")]

_UNITS = {
    "height": "height_m", "speed": "speed_m_s", "swath": "swath_m", "headland": "headland_m",
    "turn_radius": "turn_radius_m",
}  # fmt: skip


def flight_keys(**options: Any) -> dict[str, Any]:
    """The options that were given, by their keys in the survey; it checks them as it does those."""
    return {_UNITS.get(k, k): value for k, value in options.items() if value is not None}
