"""Mission files: JSON with a schema name and version, checked by the schema shipped beside this.

What is written (saving.py) is read again to the last bit.
"""

from __future__ import annotations

import json
import math
from importlib import resources
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from jsonschema import Draft202012Validator

from orchard_cli.errors import Fault, InputError
from orchard_cli.model.input_text import read_bounded
from orchard_cli.model.mission import Leg, Limits, Mission, Provenance, Segment
from orchard_cli.model.site import HeightReference, KnownObstacle, Orchard, SiteOrigin, TreeRow
from orchard_cli.model.trajectory import DEGREE, BSpline, Trajectory

from .checks import check

SCHEMA = "orchard-mission"
VERSION = 1
LARGEST = 10_000_000  # bytes
_MOST_FAULTS = 20  # listed; a file that is not a mission at all has thousands
_LIMIT_KEYS = {
    "speed": "speed_m_s",
    "acceleration": "acceleration_m_s2",
    "acceleration_along": "acceleration_along_m_s2",
    "yaw_rate": "yaw_rate_rad_s",
    "climb_speed": "climb_speed_m_s",
    "clearance": "clearance_m",
    "airframe_radius": "airframe_radius_m",
    "endurance": "endurance_s",
    "reserve": "reserve",
}


def schema() -> dict[str, Any]:
    """The JSON Schema of mission files."""
    text = resources.files(__package__).joinpath("mission.schema.json").read_text("utf-8")
    loaded: dict[str, Any] = json.loads(text)
    return loaded


def load(path: Path) -> Mission:
    """Read and check a mission file. Raises InputError with every fault."""
    return loads(read_bounded(path, LARGEST), str(path))


def load_unchecked(path: Path) -> Mission:
    """Read a mission file that may be unfit to fly, to tell what is wrong with it.

    Raises InputError with every fault of its form alone.
    """
    return _formed(read_bounded(path, LARGEST), str(path))


def loads(data: bytes | str, where: str = "mission") -> Mission:
    """A mission from the text of its file; `where` names it in faults.

    Raises InputError with every fault of the schema, else with every fault of the physics.
    """
    mission = _formed(data, where)
    faults = [Fault(f"{where}: {f.where}", f.what, f.mend) for f in check(mission)]
    if faults:
        raise InputError(faults)
    return mission


def _formed(data: bytes | str, where: str) -> Mission:
    document = _parsed(data, where)
    found = Draft202012Validator(schema()).iter_errors(document)
    errors = list(islice(found, _MOST_FAULTS + 1))
    if errors:
        faults = [
            Fault(f"{where}: {'/'.join(map(str, e.absolute_path)) or 'file'}", _short(e.message))
            for e in errors[:_MOST_FAULTS]
        ]
        if len(errors) > _MOST_FAULTS:
            faults.append(Fault(where, "has more faults than these"))
        raise InputError(faults)
    try:
        return _mission(document)
    except ValueError as error:
        raise InputError(Fault(where, str(error), "plan the mission again")) from error


def dumps(mission: Mission) -> str:
    """The text of a mission's file."""
    return _laid_out(_document(mission)) + "\n"


def _parsed(data: bytes | str, where: str) -> dict[str, Any]:
    try:
        document = json.loads(data, parse_constant=_no_constant, object_pairs_hook=_no_twins)
    except UnicodeDecodeError as error:
        raise InputError(Fault(where, "is not UTF-8 text")) from error
    except (ValueError, RecursionError) as error:
        raise InputError(Fault(where, f"is not JSON: {error}")) from error
    name = document.get("schema") if isinstance(document, dict) else None
    if name != SCHEMA:
        raise InputError(
            Fault(where, f"is no mission file (schema {name!r})", "make one with `orchard plan`")
        )
    if document.get("version") != VERSION:
        raise InputError(
            Fault(
                f"{where}: version",
                f"is {document.get('version')!r}, this program reads {VERSION}",
                "plan the mission again",
            )
        )
    return dict(document)


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is not a number")


def _no_twins(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    unique = dict(pairs)
    if len(unique) < len(pairs):
        raise ValueError("a key stands twice in one object")
    return unique


def _short(message: str) -> str:
    return message if len(message) <= 160 else f"{message[:60]} ... {message[-90:]}"


def _document(m: Mission) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "version": VERSION,
        "name": m.name,
        "provenance": {
            "survey": m.provenance.survey,
            "survey_sha256": m.provenance.survey_sha256,
            "tool_version": m.provenance.tool_version,
            "created_utc": m.provenance.created_utc,
        },
        "orchard": _orchard_document(m.orchard),
        "limits": {key: getattr(m.limits, name) for name, key in _LIMIT_KEYS.items()},
        "swath_m": m.swath,
        "route_length_m": m.route_length,
        "corner_cut_m": m.corner_cut,
        "energy_share": m.energy_share,
        "takeoff_m": m.takeoff_site.tolist(),
        "landing_m": m.landing_site.tolist(),
        "waypoints_m": m.waypoints_site.tolist(),
        "waypoints_wgs84": m.waypoints_wgs84.tolist(),
        "segments": [
            {"leg": s.leg.value, "start_s": s.start, "end_s": s.end}
            | ({} if s.row is None else {"row": s.row})
            for s in m.segments
        ],
        "spline": {
            "degree": m.spline.degree,
            "knots_m": m.spline.knots.tolist(),
            "control_points_m": m.spline.control_points_site.tolist(),
        },
        "trajectory": {
            "start_s": m.trajectory.start,
            "interval_s": m.trajectory.interval,
            "control_points_m": m.trajectory.control_points_site.tolist(),
        },
    }


def _orchard_document(orchard: Orchard) -> dict[str, Any]:
    origin = orchard.origin
    return {
        "origin": {
            "latitude_deg": origin.latitude_deg,
            "longitude_deg": origin.longitude_deg,
            "height_m": origin.height,
            "height_reference": origin.height_reference.value,
            "heading_deg": _degrees(origin.heading),
        },
        "rows": [
            {
                "trunks_m": row.trunks_site.tolist(),
                "ground_m": row.ground.tolist(),
                "tree_heights_m": row.heights.tolist(),
            }
            for row in orchard.rows
        ],
        "obstacles": [
            {"name": o.name, "at_m": o.position_site.tolist(), "radius_m": o.radius, "top_m": o.top}
            for o in orchard.obstacles
        ],
        "fence_m": orchard.fence_site.tolist(),
        "keep_outs_m": [ring.tolist() for ring in orchard.keep_outs_site],
    }


def _degrees(angle: float) -> float:
    """The shortest degrees that give the angle (rad) back to the last bit, if there are any."""
    exact = math.degrees(angle)
    near = (round(exact, 9), exact, math.nextafter(exact, 1e9), math.nextafter(exact, -1e9))
    return next((d for d in near if math.radians(d) == angle), exact)


def _mission(d: dict[str, Any]) -> Mission:
    limits = Limits(**{name: float(d["limits"][key]) for name, key in _LIMIT_KEYS.items()})
    spline, trajectory = d["spline"], d["trajectory"]
    return Mission(
        name=d["name"],
        orchard=_orchard(d["name"], d["orchard"]),
        waypoints_site=np.array(d["waypoints_m"]),
        waypoints_wgs84=np.array(d["waypoints_wgs84"]),
        route_length=float(d["route_length_m"]),
        corner_cut=float(d["corner_cut_m"]),
        spline=BSpline(DEGREE, np.array(spline["knots_m"]), np.array(spline["control_points_m"])),
        trajectory=Trajectory(
            float(trajectory["start_s"]),
            float(trajectory["interval_s"]),
            np.array(trajectory["control_points_m"]),
        ),
        segments=tuple(
            Segment(
                Leg(s["leg"]),
                float(s["start_s"]),
                float(s["end_s"]),
                int(s["row"]) if "row" in s else None,
            )
            for s in d["segments"]
        ),
        takeoff_site=np.array(d["takeoff_m"]),
        landing_site=np.array(d["landing_m"]),
        limits=limits,
        swath=float(d["swath_m"]),
        energy_share=float(d["energy_share"]),
        provenance=Provenance(**d["provenance"]),
    )


def _orchard(name: str, d: dict[str, Any]) -> Orchard:
    o = d["origin"]
    return Orchard(
        name=name,
        origin=SiteOrigin(
            float(o["latitude_deg"]),
            float(o["longitude_deg"]),
            float(o["height_m"]),
            HeightReference(o["height_reference"]),
            math.radians(o["heading_deg"]),
        ),
        rows=tuple(
            TreeRow(np.array(r["trunks_m"]), np.array(r["ground_m"]), np.array(r["tree_heights_m"]))
            for r in d["rows"]
        ),
        obstacles=tuple(
            KnownObstacle(np.array(b["at_m"]), float(b["radius_m"]), float(b["top_m"]), b["name"])
            for b in d["obstacles"]
        ),
        fence_site=np.array(d["fence_m"]).reshape(-1, 2),
        keep_outs_site=tuple(np.array(ring) for ring in d["keep_outs_m"]),
    )


def _laid_out(value: Any, indent: int = 0) -> str:
    """JSON with one point, row or entry a line: short, and fit for a diff."""
    flat = json.dumps(value, allow_nan=False, ensure_ascii=False)
    if len(flat) + indent <= 100:
        return flat
    pad = " " * (indent + 1)
    if isinstance(value, dict):
        lines = [f"{json.dumps(k)}: {_laid_out(v, indent + 1)}" for k, v in value.items()]
        return "{\n" + ",\n".join(pad + line for line in lines) + "\n" + " " * indent + "}"
    if isinstance(value, list):
        lines = [_laid_out(v, indent + 1) for v in value]
        return "[\n" + ",\n".join(pad + line for line in lines) + "\n" + " " * indent + "]"
    return flat
