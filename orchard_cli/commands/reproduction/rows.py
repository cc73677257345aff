"""A figure of a paper beside ours."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

SCHEMA = "orchard-reproduce/1"


@dataclass(frozen=True, slots=True)
class Row:
    """One cell of one table. None: the paper does not say, or it could not be measured here."""

    table: str  # as the paper counts: "Table 4", "Fig. 13"
    row: str
    column: str
    paper: float | None
    ours: float | None
    unit: str
    note: str = ""  # why it differs, or how it was measured

    def __post_init__(self) -> None:
        for name in ("paper", "ours"):
            value = getattr(self, name)
            if value is not None:
                number = float(value)
                object.__setattr__(self, name, number if math.isfinite(number) else None)


def document(rows: Sequence[Row]) -> dict[str, Any]:
    """What `--json` prints."""
    return {"schema": SCHEMA, "rows": [asdict(row) for row in rows]}


def difference(row: Row) -> str:
    """Ours less the paper's, with the share of the paper's where that says something."""
    if row.paper is None or row.ours is None:
        return ""
    less = row.ours - row.paper
    share = f" ({100 * less / row.paper:+.0f} %)" if abs(row.paper) > 1e-9 else ""
    return f"{less:+.3g}{share}"
