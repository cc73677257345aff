"""Is the mission fit to fly? Every fault is found, and each says what would mend it."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.spatial import cKDTree

from orchard_cli.errors import Fault
from orchard_cli.geometry.geodesy import wgs84_from_site
from orchard_cli.model.arrays import Points, Vector
from orchard_cli.model.mission import Leg, Limits, Mission
from orchard_cli.model.site import Orchard
from orchard_cli.model.trajectory import DEGREE
from orchard_cli.motion.fit import distances, evaluate
from orchard_cli.motion.timing import TOLERANCE, PathLimits, over_limits

from . import stores

CANOPY_REACH = 1.5  # m around a trunk within which its canopy is expected
SAMPLING = 0.1  # m between samples of a path, at most, at full speed
MICRON = 2e-6  # m: what rounding to files may move a point
NEAR = 0.05  # m: how well the parts of one mission must agree


def check(mission: Mission) -> tuple[Fault, ...]:
    """Everything that is wrong with a mission; empty when it may fly."""
    faults = stores.battery_faults(mission.energy_share, mission.limits)
    faults += stores.tank_faults(mission)
    if mission.trajectory.end > mission.limits.endurance:  # nothing to gain from looking closer
        told = any(fault.where == "battery" for fault in faults)
        long = Fault("trajectory", "is longer than the battery lasts")
        return tuple(faults) if told else (*faults, long)
    path = flown(mission)
    return (
        *faults,
        *canopy_faults(mission.orchard, mission.limits, path),
        *area_faults(mission.orchard, mission.limits, path),
        *_terrain_faults(mission.orchard, mission.limits, path),
        *_ground_faults(mission),
        *_limit_faults(mission),
        *_agreement_faults(mission, path),
        *_spline_faults(mission, path),
        *_segment_faults(mission),
    )


def flown(mission: Mission) -> Points:
    """The trajectory's positions (n, 3) m, at most SAMPLING apart."""
    trajectory, step = mission.trajectory, SAMPLING / mission.limits.speed
    return trajectory.sample(np.arange(trajectory.start, trajectory.end + step, step))[0]


def canopy_faults(orchard: Orchard, limits: Limits, path_site: Points) -> list[Fault]:
    """Rows whose canopy comes nearer than the clearance to a path sampled densely (n, 3).

    A canopy is a cylinder of CANOPY_REACH round its trunk, up to its top.
    """
    path, kept = cKDTree(path_site[:, :2]), limits.clearance
    faults = []
    for k, row in enumerate(orchard.rows):
        near = path.query_ball_point(row.trunks_site, CANOPY_REACH + kept)
        rooms = [
            _nearest(path_site[points], trunk, float(top))
            for points, trunk, top in zip(near, row.trunks_site, row.canopy_tops_site, strict=True)
        ]
        tree = int(np.argmin([apart for apart, _ in rooms]))
        apart, above = rooms[tree]
        if apart < kept - 1e-6:
            faults.append(
                Fault(
                    f"row {k + 1}, tree {tree + 1}",
                    f"the flight passes {above:.2f} m above the canopy"
                    if above >= 0
                    else f"the flight passes {-above:.2f} m below the canopy's top",
                    f"fly at least {kept - above:.2f} m higher ({kept:g} m are kept)",
                )
            )
    return faults


def _nearest(points: Points, trunk: Vector, top: float) -> tuple[float, float]:
    """Distance, m, of the nearest of the points to a canopy, and the height above its top there."""
    if not len(points):
        return np.inf, np.inf
    beside = np.hypot(*(points[:, :2] - trunk).T) - CANOPY_REACH
    above = points[:, 2] - top
    outside = np.hypot(np.maximum(beside, 0), np.maximum(above, 0))
    apart = np.where((beside > 0) | (above > 0), outside, np.maximum(beside, above))
    worst = int((apart + 1e-9 * above).argmin())
    over = above[beside <= 0].min(initial=np.inf)
    return float(apart[worst]), float(min(over, above[worst]))


def area_faults(orchard: Orchard, limits: Limits, path_site: Points) -> list[Fault]:
    """Where a path leaves the fence or enters a keep-out, with the airframe's radius to spare."""
    line = shapely.LineString(path_site[:, :2])
    room = limits.airframe_radius
    faults = _ring_faults(orchard)
    if faults:
        return faults
    if len(orchard.fence_site):
        outside = line.difference(shapely.Polygon(orchard.fence_site).buffer(-room))
        if not outside.is_empty:
            x, y = outside.representative_point().coords[0]
            faults.append(
                Fault("fence", f"the flight leaves it near ({x:.1f}, {y:.1f})", "widen the fence")
            )
    for k, ring in enumerate(orchard.keep_outs_site):
        inside = line.intersection(shapely.Polygon(ring).buffer(room))
        if not inside.is_empty:
            x, y = inside.representative_point().coords[0]
            faults.append(
                Fault(
                    f"keep_out {k + 1}",
                    f"the flight enters it near ({x:.1f}, {y:.1f})",
                    "leave those rows out, or make the keep-out smaller",
                )
            )
    return faults


def _ring_faults(orchard: Orchard) -> list[Fault]:
    rings = {f"keep_out {k}": ring for k, ring in enumerate(orchard.keep_outs_site, 1)}
    if len(orchard.fence_site):
        rings["fence"] = orchard.fence_site
    return [
        Fault(name, "is no polygon, or its outline crosses itself", "order its corners")
        for name, ring in rings.items()
        if len(ring) < 3 or not shapely.Polygon(ring).is_valid
    ]


def _terrain_faults(orchard: Orchard, limits: Limits, path_site: Points) -> list[Fault]:
    """Where a path comes nearer to the known ground than the clearance, or leaves it."""
    terrain = orchard.terrain
    if terrain is None:
        return []
    places = path_site[:, :2]
    known = (places >= terrain.corner_site - NEAR) & (places <= terrain.far_corner_site + NEAR)
    if not known.all():
        x, y = places[int((~known.all(axis=1)).argmax())]
        what = f"the flight leaves it near ({x:.1f}, {y:.1f})"
        return [Fault("terrain", what, "plan it with a larger piece of the terrain")]
    above = path_site[:, 2] - terrain.ground(places)
    worst = int(above.argmin())
    if above[worst] >= limits.clearance - 1e-6:
        return []
    x, y = places[worst]
    lack = limits.clearance - above[worst]
    return [
        Fault(
            "terrain",
            f"the flight passes {above[worst]:.2f} m above the ground near ({x:.1f}, {y:.1f})",
            f"fly at least {lack:.2f} m higher ({limits.clearance:g} m are kept)",
        )
    ]


def _ground_faults(mission: Mission) -> list[Fault]:
    """Take-off and landing go straight up and down: nothing may stand there."""
    faults = []
    trunks = np.concatenate([row.trunks_site for row in mission.orchard.rows])
    room = CANOPY_REACH + mission.limits.airframe_radius
    for name, site in (("takeoff", mission.takeoff_site), ("landing", mission.landing_site)):
        tree = float(np.hypot(*(trunks - site).T).min())
        if tree < room:
            faults.append(
                Fault(name, f"a trunk stands {tree:.2f} m away", f"keep {room:.2f} m from trees")
            )
        for obstacle in mission.orchard.obstacles:
            gap = float(np.hypot(*(obstacle.position_site - site))) - obstacle.radius
            if gap < mission.limits.clearance:
                faults.append(
                    Fault(
                        name,
                        f"{obstacle.name} stands {max(gap, 0):.2f} m away",
                        f"keep {mission.limits.clearance:g} m from it",
                    )
                )
    return faults


def _limit_faults(mission: Mission) -> list[Fault]:
    over = over_limits(mission.trajectory, PathLimits.of(mission.limits))
    return [
        Fault("trajectory", f"{share:.0%} of the limit on {name}", "plan the mission again")
        for name, share in over.items()
        if share > 1 + TOLERANCE
    ]


def _agreement_faults(mission: Mission, path: Points) -> list[Fault]:
    """The parts of a mission say the same thing."""
    waypoints = np.asarray(mission.waypoints_site)
    length = float(np.linalg.norm(np.diff(waypoints, axis=0), axis=1).sum())
    places = wgs84_from_site(mission.orchard.origin, waypoints)
    first, last = mission.trajectory.sample(
        np.array([mission.trajectory.start, mission.trajectory.end])
    )[0]
    apart = distances(waypoints, path) - mission.corner_cut
    spline = mission.spline.control_points_site
    still = np.ptp(_ends(mission.trajectory.control_points_site), axis=1).max()
    tests = (
        ("route_length_m", abs(length - mission.route_length) < 0.01),
        ("waypoints", bool((apart < NEAR).all())),
        ("waypoints wgs84", _far(places, mission.waypoints_wgs84) < NEAR),
        ("spline", np.abs(spline[[0, -1]] - waypoints[[0, -1]]).max() < NEAR),
        ("trajectory start", np.abs(first[:2] - mission.takeoff_site).max() < NEAR),
        ("trajectory end", np.abs(last[:2] - mission.landing_site).max() < NEAR),
        ("trajectory rest", still < 1e-9),
        ("energy_share", mission.energy_share * mission.limits.endurance >= mission.trajectory.end),
    )
    return [
        Fault(name, "does not agree with the rest of the mission", "plan the mission again")
        for name, holds in tests
        if not holds
    ]


def _spline_faults(mission: Mission, path: Points) -> list[Fault]:
    """The global spline is one, passes the waypoints, and lies along the trajectory."""
    again = "plan the mission again"
    knots, room = mission.spline.knots, mission.corner_cut + SAMPLING
    clamped = not np.ptp(knots[: DEGREE + 1]) and not np.ptp(knots[-DEGREE - 1 :])
    if not clamped or knots[0] != 0 or (np.diff(knots[DEGREE:-DEGREE]) <= 0).any():
        return [Fault("spline knots", "do not increase from 0, or are not clamped", again)]
    if knots[-1] > mission.route_length + NEAR:
        return [Fault("spline knots", "go on beyond the route's length", again)]
    at = np.linspace(0.0, knots[-1], int(knots[-1] / SAMPLING) + 2)
    curve = evaluate(mission.spline, at)
    if not (cKDTree(curve).query(mission.waypoints_site)[0] < room).all():
        return [Fault("spline", "passes too far from a waypoint", again)]
    if not (cKDTree(path).query(curve)[0] < room).all():
        return [Fault("spline", "lies too far from the trajectory", again)]
    return []


def _ends(control: Points) -> Points:
    """The three control points at either end, (2, 3, 3): equal means at rest."""
    return np.stack([control[:3], control[-3:]])


def _far(a_wgs84: Points, b_wgs84: Points) -> float:
    """Greatest distance of two lists of WGS84 places, m, to a few percent."""
    metres = np.abs(a_wgs84 - b_wgs84) * [111_320.0, 111_320.0, 1.0]
    return float(metres.max())


def _segment_faults(mission: Mission) -> list[Fault]:
    """Segments cover the trajectory without gap or overlap, and rows are rows of the orchard."""
    segments, end = mission.segments, mission.trajectory.end
    starts = [s.start for s in segments]
    ends = [s.end for s in segments]
    whole = bool(segments) and starts[0] == 0.0 and ends[-1] == end and starts[1:] == ends[:-1]
    faults = []
    if not whole or any(a >= b for a, b in zip(starts, ends, strict=True)):
        faults.append(Fault("segments", "leave a gap or overlap", "plan the mission again"))
    reached = [s.until for s in segments]
    moved = [s.until - before for s, before in zip(segments, [0, *reached], strict=False)]
    if (
        not reached
        or reached[-1] != len(mission.waypoints_site) - 1
        or any(
            (step != 0) if s.leg is Leg.TRANSIT and k in (0, len(segments) - 1) else step < 1
            for k, (s, step) in enumerate(zip(segments, moved, strict=True))
        )
    ):
        faults.append(Fault("segments/until", "the waypoints are not reached one after another"))
    for k, s in enumerate(segments):
        known = s.row is not None and 0 <= s.row < len(mission.orchard.rows)
        if (s.leg is Leg.ROW) != (s.row is not None) or (s.row is not None and not known):
            faults.append(Fault(f"segments/{k}", f"row {s.row} is no row of the orchard"))
    return faults
