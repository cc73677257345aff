"""What a drawing (GeoJSON, KML, a sheet of positions) holds, whatever file it came in."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from orchard_cli.errors import Fault
from orchard_cli.model.arrays import Array

from .reading import shown

MOST_FEATURES = 100_000
MOST_PROPERTIES = 100  # of one feature

Value = str | float


class Shape(Enum):
    """What a feature is on paper."""

    POINT = "point"
    LINE = "line"
    POLYGON = "polygon"


@dataclass(frozen=True, slots=True, eq=False)
class Feature:
    """One point, line or polygon; a multi-geometry is several."""

    where: str  # in the file, for faults
    shape: Shape
    parts: tuple[Array, ...]
    """Each (n, 3): latitude deg, longitude deg, height m (NaN: not told). A point and a line have
    one part; a polygon has its outer ring, then its inner rings, none of them closed."""
    name: str = ""
    layers: tuple[str, ...] = ()  # folders, outermost first
    properties: Mapping[str, Value] = field(default_factory=dict)  # keys in small letters

    def number(self, *keys: str) -> float:
        """The first of the properties that is a number; NaN when none is."""
        for key in keys:
            value = as_number(self.properties.get(key, ""))
            if math.isfinite(value):
                return value
        return math.nan


@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """All features of a file."""

    file: str
    features: tuple[Feature, ...]


def as_number(value: Value) -> float:
    """A property as a number, with a decimal point or comma; NaN when it is none."""
    if isinstance(value, str):
        try:
            value = float(value.strip().replace(",", "."))
        except ValueError:
            return math.nan
    return value if math.isfinite(value) else math.nan


def places(
    where: str, positions: Sequence[Sequence[float]], faults: list[Fault], least: int
) -> Array | None:
    """(n, 3) from positions of longitude, latitude and perhaps height; None and a fault when wrong.

    `least` is how many are needed.
    """
    if len(positions) < least:
        faults.append(Fault(where, f"has {len(positions)} positions", f"{least} are needed"))
        return None
    for k, position in enumerate(positions, 1):
        if not 2 <= len(position) <= 4:
            faults.append(
                Fault(
                    f"{where}: position {k}",
                    f"is {shown(list(position))}",
                    "write longitude, latitude and, if you like, the height",
                )
            )
            return None
    rows = [(p[1], p[0], p[2] if len(p) > 2 else math.nan) for p in positions]
    found = np.array(rows, dtype=np.float64)
    return found if _on_earth(where, found, faults) else None


def _on_earth(where: str, found: Array, faults: list[Fault]) -> bool:
    latitude, longitude, height = found.T
    wrong = ~((np.abs(latitude) <= 90) & (np.abs(longitude) <= 180))
    wrong |= ~(np.isnan(height) | (np.abs(height) <= 9_000))
    if not wrong.any():
        return True
    k = int(wrong.argmax())
    swapped = abs(latitude[k]) <= 180 and abs(longitude[k]) <= 90
    faults.append(
        Fault(
            f"{where}: position {k + 1}",
            f"is latitude {latitude[k]:g}, longitude {longitude[k]:g}, height {height[k]:g}",
            "longitude comes first, then latitude" if swapped else "save it in WGS84 degrees",
        )
    )
    return False


def ring(where: str, found: Array | None, faults: list[Fault]) -> Array | None:
    """A closed ring of at least four positions without its last one, which repeats the first."""
    if found is None:
        return None
    if not np.array_equal(found[0, :2], found[-1, :2]):
        faults.append(Fault(where, "is not closed", "end the ring where it begins"))
        return None
    return found[:-1]


def properties_of(values: Mapping[str, object]) -> dict[str, Value]:
    """Texts and numbers among a feature's properties, keys in small letters.

    Others (lists, tables, nothing) cannot be a height or a kind.
    """
    kept: dict[str, Value] = {}
    for key, value in list(values.items())[:MOST_PROPERTIES]:
        if isinstance(value, bool):
            continue
        if isinstance(value, str | int | float):
            kept[key.strip().lower()] = value if isinstance(value, str) else _float(value)
    return kept


def _float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.nan
