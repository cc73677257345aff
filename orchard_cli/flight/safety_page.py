"""The safety table as the page docs/safety.md shows it.

`python -m orchard_cli.flight.safety_page docs/safety.md` writes it there anew; a test compares.
"""

from __future__ import annotations

import sys
from pathlib import Path

from .safety import TABLE, Hazard, Phase

BEGIN, END = "<!-- the table: generated -->\n", "<!-- the table: end -->\n"


def table_page() -> str:
    """Every phase and hazard, in order of precedence, as a Markdown table."""
    phases = tuple(Phase)
    lines = [
        f"| | {' | '.join(phase.value for phase in phases)} |",
        f"|---|{'---|' * len(phases)}",
    ]
    for hazard in Hazard:
        cells = (TABLE[phase, hazard] for phase in phases)
        words = ("·" if cell is None else cell.value for cell in cells)
        lines.append(f"| {hazard.value} | {' | '.join(words)} |")
    return "\n".join(lines) + "\n"


def renewed(page: str) -> str:
    """The page with the table as it is now between its marks."""
    head, rest = page.split(BEGIN)
    return head + BEGIN + table_page() + END + rest.split(END)[1]


if __name__ == "__main__":
    place = Path(sys.argv[1])
    place.write_text(renewed(place.read_text()))
