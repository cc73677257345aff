"""QGroundControl's .plan: simple items alone, since other tools drop complex ones unsaid.

Format: QGroundControl developer guide, "Plan File Format". The fence is an inclusion polygon, each
keep-out an exclusion polygon, the take-off point the rally point.
"""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.arrays import Array

from .course import Course, Loaded
from .items import Frame, Item, Pump, items, loaded

_ITEM = "SimpleItem"


class _Item(msgspec.Struct):
    command: int
    frame: int
    params: list[float | None]
    type: str


class _Mission(msgspec.Struct):
    items: list[_Item]


class _Polygon(msgspec.Struct):
    inclusion: bool
    polygon: list[tuple[float, float]]


class _Fence(msgspec.Struct):
    polygons: list[_Polygon]


class _Plan(msgspec.Struct, rename="camel"):
    file_type: str
    mission: _Mission
    geo_fence: _Fence


def write(course: Course, pump: Pump) -> bytes:
    """The text of a .plan file."""
    listed = [_item(k, item) for k, item in enumerate(items(course, pump), 1)]
    rings = [(True, course.fence_wgs84)] if len(course.fence_wgs84) else []
    rings += [(False, ring) for ring in course.keep_outs_wgs84]
    home = [round(float(v), d) for v, d in zip(course.home_wgs84, (9, 9, 4), strict=True)]
    document = {
        "fileType": "Plan",
        "geoFence": {
            "circles": [],
            "polygons": [
                {"inclusion": inside, "polygon": _corners(ring), "version": 1}
                for inside, ring in rings
            ],
            "version": 2,
        },
        "groundStation": "QGroundControl",
        "mission": {
            "cruiseSpeed": course.speed,
            "firmwareType": pump.firmware,
            "globalPlanAltitudeMode": 1,
            "hoverSpeed": course.speed,
            "items": listed,
            "plannedHomePosition": home,
            "vehicleType": 2,
            "version": 2,
        },
        "rallyPoints": {
            "points": [[*home[:2], round(float(course.heights[0]), 4)]],
            "version": 2,
        },
        "version": 1,
    }
    return msgspec.json.format(msgspec.json.encode(document), indent=1) + b"\n"


def _item(number: int, item: Item) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "autoContinue": True,
        "command": int(item.command),
        "doJumpId": number,
        "frame": int(item.frame),
        "params": list(item.params),
        "type": _ITEM,
    }
    if item.frame == Frame.RELATIVE:
        entry |= {"AMSLAltAboveTerrain": None, "Altitude": item.params[6], "AltitudeMode": 1}
    return entry


def _corners(ring: Array) -> list[list[float]]:
    return [[round(float(v), 9) for v in corner] for corner in ring]


def read(data: bytes) -> Loaded:
    """Read a .plan file of simple items. Raises InputError for anything else."""
    try:
        plan = msgspec.json.decode(data, type=_Plan)
    except (msgspec.DecodeError, RecursionError) as error:
        raise InputError(Fault("plan", f"is no QGroundControl plan: {error}")) from error
    if plan.file_type != "Plan" or any(
        i.type != _ITEM or len(i.params) != 7 for i in plan.mission.items
    ):
        raise InputError(Fault("plan", "has items that are not simple"))
    found = loaded([Item(i.command, i.frame, tuple(i.params)) for i in plan.mission.items])
    fences = [_ring(p) for p in plan.geo_fence.polygons if p.inclusion]
    if len(fences) > 1:
        raise InputError(Fault("plan", "has more than one fence"))
    return Loaded(
        found.places_wgs84,
        found.heights,
        found.sprays,
        fences[0] if fences else np.empty((0, 2)),
        tuple(_ring(p) for p in plan.geo_fence.polygons if not p.inclusion),
    )


def _ring(polygon: _Polygon) -> Array:
    return np.array(polygon.polygon, dtype=np.float64).reshape(-1, 2)
