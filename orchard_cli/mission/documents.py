"""Missions as JSON documents, and back to the last bit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from orchard_cli.model.mission import (
    Leg,
    Limits,
    Mission,
    Provenance,
    Segment,
    Sortie,
    Tank,
)
from orchard_cli.model.site import HeightReference, KnownObstacle, Orchard, SiteOrigin, TreeRow
from orchard_cli.model.terrain import Terrain
from orchard_cli.model.trajectory import DEGREE, BSpline, Trajectory

SCHEMA = "orchard-mission"
VERSION = 2
_MINUTE = 60.0  # s
_HECTARE = 1e4  # m²
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


def document_of(m: Mission) -> dict[str, Any]:
    """What a mission's file holds."""
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
        **_stores_document(m),
        "takeoff_m": m.takeoff_site.tolist(),
        "landing_m": m.landing_site.tolist(),
        "waypoints_m": m.waypoints_site.tolist(),
        "waypoints_wgs84": m.waypoints_wgs84.tolist(),
        "segments": [
            {"leg": s.leg.value, "start_s": s.start, "end_s": s.end, "until": s.until}
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


def _stores_document(m: Mission) -> dict[str, Any]:
    """What a mission without a tank, or of one flight, leaves out."""
    document: dict[str, Any] = {}
    if m.tank is not None:
        document["tank"] = {"capacity_l": m.tank.capacity}
        if m.tank.flow is not None:
            document["tank"]["flow_l_min"] = round(m.tank.flow * _MINUTE, 9)
        if m.tank.dose is not None:
            document["tank"]["dose_l_ha"] = round(m.tank.dose * _HECTARE, 9)
        document["liquid_l"] = m.liquid
    if m.sortie is not None:
        document["sortie"] = {"number": m.sortie.number, "of": m.sortie.of}
    return document


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
        **_terrain_document(orchard.terrain),
    }


def _terrain_document(terrain: Terrain | None) -> dict[str, Any]:
    """What an orchard without a terrain leaves out."""
    if terrain is None:
        return {}
    return {
        "terrain": {
            "corner_m": terrain.corner_site.tolist(),
            "step_m": terrain.step,
            "ground_m": terrain.heights.tolist(),
        }
    }


def _degrees(angle: float) -> float:
    """The shortest degrees that give the angle (rad) back to the last bit, if there are any."""
    exact = math.degrees(angle)
    near = (round(exact, 9), exact, math.nextafter(exact, 1e9), math.nextafter(exact, -1e9))
    return next((d for d in near if math.radians(d) == angle), exact)


def mission_of(d: dict[str, Any]) -> Mission:
    """The mission of a document that keeps the schema. Raises ValueError for wrong shapes."""
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
                int(s["until"]),
            )
            for s in d["segments"]
        ),
        takeoff_site=np.array(d["takeoff_m"]),
        landing_site=np.array(d["landing_m"]),
        limits=limits,
        swath=float(d["swath_m"]),
        energy_share=float(d["energy_share"]),
        provenance=Provenance(**d["provenance"]),
        tank=_tank(d["tank"]) if "tank" in d else None,
        liquid=float(d["liquid_l"]) if "liquid_l" in d else None,
        sortie=Sortie(int(d["sortie"]["number"]), int(d["sortie"]["of"]))
        if "sortie" in d
        else None,
    )


def _tank(d: dict[str, Any]) -> Tank:
    return Tank(
        float(d["capacity_l"]),
        d["flow_l_min"] / _MINUTE if "flow_l_min" in d else None,
        d["dose_l_ha"] / _HECTARE if "dose_l_ha" in d else None,
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
        terrain=_terrain(d["terrain"]) if "terrain" in d else None,
    )


def _terrain(d: dict[str, Any]) -> Terrain:
    return Terrain(np.array(d["corner_m"]), float(d["step_m"]), np.array(d["ground_m"]))
