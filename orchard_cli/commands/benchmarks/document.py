"""The JSON document of a bench, and the comparison with an older one."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from orchard_cli.errors import Fault, InputError

SCHEMA = "orchard-bench/1"
FIGURES = ("median_ms", "p95_ms", "p99_ms", "max_ms")


def plain(value: Any, digits: int = 5) -> Any:
    """Dataclasses as dictionaries, numbers rounded to what they can tell."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = dataclasses.asdict(value)
    if isinstance(value, Mapping):
        return {key: plain(item, digits) for key, item in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [plain(item, digits) for item in value]
    return round(value, digits) if isinstance(value, float) else value


def load(path: Path) -> dict[str, Any]:
    """An older document. Raises InputError when it is none."""
    try:
        found = json.loads(path.read_text())
    except OSError as error:
        raise InputError(Fault(str(path), error.strerror or str(error))) from None
    except ValueError:
        found = None
    if not isinstance(found, dict) or found.get("schema") != SCHEMA:
        mend = "name a file of `orchard bench --json`"
        raise InputError(Fault(str(path), "no document of a bench", mend))
    return found


def ratios(new: Mapping[str, Any], old: Mapping[str, Any]) -> dict[str, dict[str, float]]:
    """New over old of every figure that both have; below 1 is faster. Replans stand as
    "system/field".
    """
    before, now = _spreads(old), _spreads(new)
    return {
        name: {
            figure: round(now[name][figure] / before[name][figure], 3)
            for figure in FIGURES
            if before[name].get(figure)
        }
        for name in now
        if name in before
    }


def _spreads(document: Mapping[str, Any]) -> dict[str, Mapping[str, float]]:
    found = dict(document["stages"])
    for system, fields in document.get("replanning", {}).items():
        for field, figures in fields.items():
            if figures["replan"] is not None:
                found[f"{system}/{field}"] = figures["replan"]
    return found
