"""A figure of a paper beside ours."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
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
    flights: int = 1  # of which `ours` is the median
    low: float | None = None  # least and greatest of several flights
    high: float | None = None

    def __post_init__(self) -> None:
        for name in ("paper", "ours"):
            value = getattr(self, name)
            if value is not None:
                number = float(value)
                object.__setattr__(self, name, number if math.isfinite(number) else None)

    @property
    def spread(self) -> str:
        """Least to greatest; empty for one flight."""
        return "" if self.low is None else f"{self.low:.4g} to {self.high:.4g}"


_KEYS = ("table", "row", "column", "paper", "ours", "unit")


def document(rows: Sequence[Row]) -> dict[str, Any]:
    """What `--json` prints: of several flights the median, and their spread in the note."""
    return {"schema": SCHEMA, "rows": [_entry(row) for row in rows]}


def _entry(row: Row) -> dict[str, Any]:
    of = f"median of {row.flights} flights, {row.spread}" if row.spread else ""
    found = {key: _short(getattr(row, key)) for key in _KEYS}
    return {**found, "note": "; ".join(filter(None, (of, row.note)))}


def _short(value: str | float | None) -> str | float | None:
    """Six figures are more than any of these is good for."""
    return float(f"{value:.6g}") if isinstance(value, float) else value


def difference(row: Row) -> str:
    """Ours less the paper's, with the share of the paper's where that says something."""
    if row.paper is None or row.ours is None:
        return ""
    less = row.ours - row.paper
    share = f" ({100 * less / row.paper:+.0f} %)" if abs(row.paper) > 1e-9 else ""
    return f"{less:+.3g}{share}"
