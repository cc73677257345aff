"""Rules about where the vehicle flies: trees, obstacles, fence, keep-outs, ground."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely
from scipy.spatial import cKDTree

from orchard_cli.geometry.clearance import clearance
from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.mission import Mission
from orchard_cli.model.site import Orchard
from orchard_cli.model.world import World

from .flown import Flown
from .report import Finding, Rule, Sense, judge_along, judge_total
from .terrain import Terrain

CANOPY_REACH = 1.5  # m round a trunk within which its canopy is expected
SEEN = 3.0  # m: a tree farther from the flight than this is not measured
MILLIMETRE = 1e-3
_PART = 4_000  # samples at a time: bounds the memory in dense orchards


@dataclass(frozen=True, slots=True)
class HeightBand:
    """How high above the ground the flight has to stay; metres."""

    lowest: float
    highest: float


def space_findings(
    mission: Mission, flown: Flown, terrain: Terrain, band: HeightBand, world: World | None
) -> list[Finding]:
    """Everything that stands, is fenced off, or lies below."""
    kept, radius = mission.limits.clearance, mission.limits.airframe_radius
    findings = _trees(mission.orchard, flown, kept)
    findings += _obstacles(mission.orchard, flown, kept)
    if world is not None:
        findings += _world(world, flown, kept)
    return [
        *findings,
        *_areas(mission.orchard, flown, radius),
        *_heights(flown, terrain, band),
        *_ends(mission, flown),
    ]


def _trees(orchard: Orchard, flown: Flown, kept: float) -> list[Finding]:
    """Each tree is an upright cylinder of CANOPY_REACH up to its top."""
    trunks = np.concatenate([row.trunks_site for row in orchard.rows])
    tops = np.concatenate([row.canopy_tops_site for row in orchard.rows])
    names = [f"row {r}, tree {t}" for r, row in enumerate(orchard.rows, 1)
             for t in range(1, len(row.heights) + 1)]  # fmt: skip
    near, which = _nearest_cylinder(flown.positions, trunks, tops, CANOPY_REACH, kept)
    rule = Rule("clearance to the trees", Sense.AT_LEAST, kept, "m", MILLIMETRE)
    return judge_along(rule, flown, near, [names[k] if k >= 0 else "no tree near" for k in which])


def _nearest_cylinder(
    points: Points, axes: Points, tops: Array, reach: float, kept: float
) -> tuple[Array, Array]:
    """Distance (n,) m to the nearest cylinder, and which (n,); inf and -1 where none is near."""
    nearest, which = np.full(len(points), np.inf), np.full(len(points), -1)
    stems = cKDTree(axes)
    for start in range(0, len(points), _PART):
        part = points[start : start + _PART]
        pairs = cKDTree(part[:, :2]).sparse_distance_matrix(
            stems, reach + max(SEEN, kept), output_type="ndarray"
        )
        if not len(pairs):
            continue
        beside = pairs["v"] - reach
        above = part[pairs["i"], 2] - tops[pairs["j"]]
        apart = np.where(
            (beside > 0) & (above > 0), np.hypot(beside, above), np.maximum(beside, above)
        )
        order = np.argsort(-apart)  # the nearest is written last
        nearest[start + pairs["i"][order]] = apart[order]
        which[start + pairs["i"][order]] = pairs["j"][order]
    return nearest, which


def _obstacles(orchard: Orchard, flown: Flown, kept: float) -> list[Finding]:
    """Known obstacles, each an upright cylinder from the ground to its top."""
    rule = Rule("clearance to known obstacles", Sense.AT_LEAST, kept, "m", MILLIMETRE)
    if not orchard.obstacles:
        return judge_total(rule, np.inf, "none is known")
    findings = []
    for obstacle in orchard.obstacles:
        x, y = obstacle.position_site
        beside = np.hypot(*(flown.positions[:, :2] - obstacle.position_site).T) - obstacle.radius
        above = flown.positions[:, 2] - obstacle.top
        apart = np.where(
            (beside > 0) & (above > 0), np.hypot(beside, above), np.maximum(beside, above)
        )
        findings += judge_along(rule, flown, apart, f"{obstacle.name} at ({x:g}, {y:g})")
    return findings


def _world(world: World, flown: Flown, kept: float) -> list[Finding]:
    """What stands in a world file. People walk: they are not judged."""
    apart = clearance(replace(world, people=()), flown.positions)
    rule = Rule("clearance to the world's obstacles", Sense.AT_LEAST, kept, "m", MILLIMETRE)
    trees = replace(rule, name="clearance to the world's trees")
    things = len(world.poles) + len(world.wires) + len(world.boxes)
    about = f"nearest pole, wire or box of {things}" if things else "there is none"
    return [
        *judge_along(rule, flown, apart.obstacles, about),
        *judge_along(trees, flown, apart.trees, f"nearest tree of {len(world.trees)}"),
    ]


def _areas(orchard: Orchard, flown: Flown, radius: float) -> list[Finding]:
    inside = Rule("inside the fence", Sense.AT_LEAST, radius, "m", MILLIMETRE)
    outside = Rule("outside the keep-outs", Sense.AT_LEAST, radius, "m", MILLIMETRE)
    if len(orchard.fence_site):
        findings = judge_along(inside, flown, _depth(orchard.fence_site, flown.positions))
    else:
        findings = judge_total(inside, np.inf, "there is no fence")
    for k, ring in enumerate(orchard.keep_outs_site, 1):
        away = -_depth(ring, flown.positions)
        findings += judge_along(outside, flown, away, f"keep-out {k}")
    if not orchard.keep_outs_site:
        findings += judge_total(outside, np.inf, "there is none")
    return findings


def _depth(ring: Points, points: Points) -> Array:
    """(n,) m from a polygon's outline, positive inside; NaN for a polygon that crosses itself."""
    polygon = shapely.Polygon(ring) if len(ring) >= 3 else shapely.Polygon()
    if polygon.is_empty or not polygon.is_valid:
        return np.full(len(points), np.nan)
    places = shapely.points(points[:, :2])
    shapely.prepare(polygon)
    away = shapely.distance(polygon.exterior, places)
    return np.asarray(np.where(shapely.contains(polygon, places), away, -away))


def _heights(flown: Flown, terrain: Terrain, band: HeightBand) -> list[Finding]:
    above = flown.positions[:, 2] - terrain.ground(flown.positions[:, :2])
    low = Rule("height above the ground", Sense.AT_LEAST, band.lowest, "m", MILLIMETRE)
    high = Rule("height above the ground", Sense.AT_MOST, band.highest, "m", MILLIMETRE)
    return [*judge_along(low, flown, above), *judge_along(high, flown, above)]


def _ends(mission: Mission, flown: Flown) -> list[Finding]:
    """Take-off and landing go straight up and down from the places that the mission names."""
    kept, orchard = mission.limits.clearance, mission.orchard
    room = Rule("room for take-off and landing", Sense.AT_LEAST, kept, "m", MILLIMETRE)
    met = Rule("the flight begins and ends there", Sense.AT_MOST, 0.05, "m")
    trunks = np.concatenate([row.trunks_site for row in orchard.rows])
    findings = []
    for name, site, end in (
        ("take-off", mission.takeoff_site, flown.positions[0]),
        ("landing", mission.landing_site, flown.positions[-1]),
    ):
        tree = float(np.hypot(*(trunks - site).T).min()) - CANOPY_REACH
        gaps = [(tree, "the nearest tree")] + [
            (float(np.hypot(*(o.position_site - site))) - o.radius, o.name)
            for o in orchard.obstacles
        ]
        gap, what = min(gaps)
        place: Vector = np.array([*site, end[2]])
        findings.append(Finding(room, room.keeps(gap), gap, f"{name}: {what}", place))
        off = float(np.hypot(*(end[:2] - site)))
        findings.append(Finding(met, met.keeps(off), off, name, place))
    return findings
