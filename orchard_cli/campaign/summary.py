"""Many judged flights in figures, with how sure they are."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from .judge import Outcome

CONFIDENCE = 0.95
NEAR, NEAR_WIDE = 0.85, 1.5  # m from the airframe's centre to a surface
PERSON_NEAR = 3.0  # m, level, to a person, while moving

Record = Mapping[str, Any]  # one line of the ledger: a Judgement in JSON


def share(count: int, of: int) -> dict[str, float | int | None]:
    """A count and its share, with the exact interval (Clopper and Pearson, 1934)."""
    from scipy.stats import binomtest

    if not of:
        return {"count": count, "of": 0, "share": None, "low": None, "high": None}
    sure = binomtest(count, of).proportion_ci(CONFIDENCE, method="exact")
    return {"count": count, "of": of, "share": count / of, "low": sure.low, "high": sure.high}


def summary(records: Sequence[Record]) -> dict[str, Any]:
    """Counts, shares and spreads over all flights."""
    of, outcome = len(records), Outcome
    tests: dict[str, Callable[[Record], bool]] = {
        "contacts": lambda r: r["outcome"] == outcome.CONTACT.value,
        "near_misses": lambda r: near(r, NEAR),
        "near_misses_wide": lambda r: near(r, NEAR_WIDE),
        "completed": lambda r: r["outcome"] == outcome.COMPLETED.value,
        "corners_left_out": _cut,
        "safe_ends": lambda r: r["outcome"] == outcome.SAFE.value,
        "unsafe_ends": lambda r: r["outcome"] == outcome.UNSAFE.value,
        "near_people": lambda r: (r["person_m"] or math.inf) < PERSON_NEAR,
    }
    shares = {name: share(sum(map(test, records)), of) for name, test in tests.items()}
    return {
        "flights": of,
        **{name: found["count"] for name, found in shares.items()},
        "intervals": shares,
        "by_thing": _by_thing(records),
        "over_ideal_s": spread([r["over_ideal_s"] for r in records]),
        "clearance_m": spread([r["clearance_m"] for r in records]),
        "replans": spread([r["replans"] for r in records]),
        "holds": spread([r["holds"] for r in records]),
        "early": [story(r) for r in records if r["outcome"] == outcome.SAFE.value],
        "failures": [story(r) for r in records if failed(r)],
    }


def _cut(record: Record) -> bool:
    """Whether it flew the route to its end, but left out a waypoint on the way."""
    return bool(record["outcome"] == Outcome.COMPLETED.value and record["left_out"] > 0)


def near(record: Record, limit: float) -> bool:
    """Whether it passed something nearer than that, without touching anything."""
    clearance = record["clearance_m"]
    touched = record["outcome"] == Outcome.CONTACT.value
    return not touched and clearance is not None and clearance < limit


def failed(record: Record) -> bool:
    """Whether somebody must look at it: a contact, a bad end, or passed too near."""
    bad = record["outcome"] in (Outcome.CONTACT.value, Outcome.UNSAFE.value)
    return bad or near(record, NEAR)


def story(record: Record) -> dict[str, Any]:
    """Which flight, and what became of it, in words."""
    what = record["outcome"]
    if record["contact"]:
        what = f"touched {record['contact']}"
    elif near(record, NEAR):
        nearest = min(record["nearest_m"], key=record["nearest_m"].get)
        what += f", passed a {nearest} at {record['clearance_m']:.2f} m"
    told = {key: record[key] for key in ("seed", "case")}
    return {**told, "why": f"{what}; {record['why']}", "kept": record["kept"]}


def spread(values: Sequence[float | None]) -> dict[str, float | int | None]:
    """Of what is known: how many, median, 95 % and the two ends."""
    known = np.array([value for value in values if value is not None], dtype=float)
    if not len(known):
        return {"n": 0, "min": None, "median": None, "p95": None, "max": None}
    low, middle, high, most = np.quantile(known, [0.0, 0.5, 0.95, 1.0]).tolist()
    return {"n": len(known), "min": low, "median": middle, "p95": high, "max": most}


def _by_thing(records: Sequence[Record]) -> dict[str, dict[str, int]]:
    """For each kind of thing: flights with one, contacts with one, near misses, completions."""
    kinds = sorted({kind for record in records for kind in record["nearest_m"]})
    found = {}
    for kind in kinds:
        having = [record for record in records if kind in record["nearest_m"]]
        found[kind] = {
            "flights": len(having),
            "contacts": sum(_touched(record, kind) for record in having),
            "near_misses": sum(
                record["nearest_m"][kind] < NEAR and not _touched(record, kind) for record in having
            ),
            "completed": sum(r["outcome"] == Outcome.COMPLETED.value for r in having),
        }
    return found


def _touched(record: Record, kind: str) -> bool:
    return str(record["contact"]).startswith(kind)
