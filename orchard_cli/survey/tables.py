"""The tables of a survey file, whether TOML or the head of a CSV.

name = "north field"         # optional: the file's name

[site]                       # where the first tree of the first row stands
latitude_deg = 23.45
longitude_deg = 113.2
height_m = 20.0
height_reference = "amsl"    # or "ellipsoid"
heading_deg = 90.0           # compass heading from the first tree along the first row (+x);
                             # the other rows lie to the left of it
[flight]
height_m = 3.5
height_above = "ground"      # or "canopy"
speed_m_s = 1.0              # optional from here on: model/wishes.py and model/mission.py
start_row = "first"          # have the defaults
start_side = "near"          # near is the side of the rows' first trees
takeoff_m = [-4.0, 0.0]

[vehicle]
endurance_s = 600

[tank]                       # optional; with it, liquid is counted and flights are cut by it
capacity_l = 10
dose_l_ha = 150              # or flow_l_min

[[row]]
distance_m = 6.0             # from the row before; 0 or left out in the first row
far_distance_m = 6.2         # the same at the row's last tree, when rows are not parallel
start_m = 0.5                # from the origin along x to the row's first tree
gaps_m = [3.0, 2.8, 3.1]     # between neighbouring trees
tree_height_m = 2.3          # or a list, one a tree
ground_m = 0.0               # above the ground at the origin; or a list, one a tree

[[row]]                      # or, instead of distances, gaps and start: where its trees stand
trunks_m = [[0.4, 12.1], [3.5, 12.2]]
tree_height_m = 2.3

[[obstacle]]                 # what the crew knows of: poles, masts
name = "pole"
x_m = 19.0
y_m = 6.0
radius_m = 0.15
height_m = 8.0

[fence]
points_m = [[-10, -10], [50, -10], [50, 50], [-10, 50]]

[[keep_out]]
points_m = [[5, 5], [8, 5], [8, 8]]
"""

from __future__ import annotations

import math

import numpy as np
import shapely

from orchard_cli.errors import Fault
from orchard_cli.model.arrays import Points
from orchard_cli.model.mission import Limits, Tank
from orchard_cli.model.site import HeightReference, KnownObstacle, SiteOrigin
from orchard_cli.model.wishes import (
    Direction,
    FlightWishes,
    FlyOver,
    Follow,
    HeightAbove,
    Pattern,
    StartRow,
    StartSide,
    Turn,
)

from .reading import Table
from .rows import TapedRow

MOST_ROWS = 1_000
MOST_TREES = 2_000  # in one row
FARTHEST = 5_000.0  # m from the origin
_MINUTE = 60.0  # s
_HECTARE = 1e4  # m²


def read_site(table: Table) -> SiteOrigin:
    """[site]."""
    origin = SiteOrigin(
        latitude_deg=table.number("latitude_deg", -90, 90),
        longitude_deg=table.number("longitude_deg", -180, 180),
        height=table.number("height_m", -500, 9_000),
        height_reference=table.choice("height_reference", HeightReference, HeightReference.AMSL),
        heading=math.radians(table.number("heading_deg", -360, 360)),
    )
    table.done()
    return origin


def read_tank(table: Table) -> Tank | None:
    """[tank]; None when it is wrong."""
    capacity = table.number("capacity_l", 0, 1_000, above_low=True)
    flow = dose = None
    if "flow_l_min" in table:
        flow = table.number("flow_l_min", 0, 200, above_low=True) / _MINUTE
    if "dose_l_ha" in table:
        dose = table.number("dose_l_ha", 0, 10_000, above_low=True) / _HECTARE
    if (flow is None) == (dose is None):
        what = "is missing" if flow is None else "stands beside flow_l_min"
        table.fault("dose_l_ha", what, "give flow_l_min, or dose_l_ha")
    table.done()
    told = [value for value in (capacity, flow, dose) if value is not None]
    return Tank(capacity, flow, dose) if np.isfinite(told).all() else None


def read_wishes(flight: Table, vehicle: Table, tank: Tank | None = None) -> FlightWishes:
    """[flight] and [vehicle]."""
    usual = Limits()
    limits = Limits(
        speed=flight.number("speed_m_s", 0.1, 10, usual.speed),
        acceleration=flight.number("acceleration_m_s2", 0.05, 5, usual.acceleration),
        acceleration_along=flight.number(
            "acceleration_along_m_s2", 0.05, 5, usual.acceleration_along
        ),
        yaw_rate=flight.number("yaw_rate_rad_s", 0.05, 3, usual.yaw_rate),
        climb_speed=flight.number("climb_speed_m_s", 0.1, 5, usual.climb_speed),
        clearance=vehicle.number("clearance_m", 0.1, 10, usual.clearance),
        airframe_radius=vehicle.number("airframe_radius_m", 0.05, 5, usual.airframe_radius),
        endurance=vehicle.number("endurance_s", 30, 7_200, usual.endurance),
        reserve=vehicle.number("reserve", 0.05, 0.9, usual.reserve),
    )
    if limits.clearance < limits.airframe_radius:
        vehicle.fault(
            "clearance_m",
            f"is less than the airframe's radius of {limits.airframe_radius:g} m",
            "it is measured from the airframe's centre",
        )
    wishes = FlightWishes(
        height=flight.number("height_m", 0.5, 100),
        height_above=flight.choice("height_above", HeightAbove, HeightAbove.GROUND),
        start_row=flight.choice("start_row", StartRow, StartRow.FIRST),
        start_side=flight.choice("start_side", StartSide, StartSide.NEAR),
        swath=flight.number("swath_m", 0.2, 20, 3.0),
        corner_cut=flight.number("corner_cut_m", 0.2, 3.0, 0.5),
        takeoff_site=_place(flight, "takeoff_m"),
        landing_site=_place(flight, "landing_m"),
        limits=limits,
        fly_over=flight.choice("fly_over", FlyOver, FlyOver.ROWS),
        passes=flight.whole("passes", 1, 9, 1),
        overlap=flight.number("overlap", 0, 0.9) if "overlap" in flight else None,
        pattern=flight.choice("pattern", Pattern, Pattern.EVERY),
        direction=flight.choice("direction", Direction, Direction.BOTH),
        turn=flight.choice("turn", Turn, Turn.SQUARE),
        headland=flight.number("headland_m", 0, 50, 0.0),
        turn_radius=flight.number("turn_radius_m", 0.5, 20, 3.0),
        follow=flight.choice("follow", Follow, Follow.LINE),
        tank=tank,
    )
    if "overlap" in flight and "passes" in flight:
        flight.fault("passes", "stands beside overlap", "overlap tells how many passes it takes")
    flight.done()
    vehicle.done()
    return wishes


def _place(table: Table, key: str) -> np.ndarray | None:
    """An optional (2,) m; None, too, when it is wrong and was complained of."""
    point = table.point(key)
    return None if point is None or not np.isfinite(point).all() else np.array(point)


def read_rows(tables: list[Table]) -> list[TapedRow]:
    """[[row]], in planting order."""
    rows = []
    for k, table in enumerate(tables):
        if "trunks_m" in table:
            rows.append(_placed_row(table, first=k == 0))
            continue
        gaps = table.numbers("gaps_m", 0.1, 200, MOST_TREES - 1)
        trees = len(gaps) + 1 if gaps else 0
        distance, far = read_distances(table, first=k == 0)
        rows.append(
            TapedRow(
                where=table.where,
                distance=distance,
                far_distance=far,
                start=read_start(table, first=k == 0),
                gaps=gaps or [math.nan],
                heights=table.one_or_many("tree_height_m", 0.2, 60, trees),
                ground=table.one_or_many("ground_m", -500, 500, trees, default=0.0),
            )
        )
        table.done()
    return rows


def _placed_row(table: Table, first: bool) -> TapedRow:
    """A row whose trees were placed by their coordinates."""
    points = table.points("trunks_m", 2, MOST_TREES, "row")
    trunks = np.array(points).reshape(-1, 2) if points else np.full((2, 2), math.nan)
    if np.isfinite(trunks).all():
        _check_places(table, trunks, first)
    row = TapedRow(
        where=table.where,
        distance=0.0,
        far_distance=0.0,
        start=float(trunks[0, 0]),
        gaps=np.hypot(*np.diff(trunks, axis=0).T).tolist(),
        heights=table.one_or_many("tree_height_m", 0.2, 60, len(points)),
        ground=table.one_or_many("ground_m", -500, 500, len(points), default=0.0),
        trunks=trunks,
    )
    table.done()
    return row


def _check_places(table: Table, trunks: Points, first: bool) -> None:
    """The origin is the first tree of the first row, and trees stand in the row's order."""
    if first and np.abs(trunks[0]).max() > 1e-3:
        table.fault("trunks_m[1]", f"is {trunks[0].tolist()}", "the first tree is the origin, 0, 0")
    way = trunks[-1] - trunks[0]
    back = np.flatnonzero(np.diff(trunks @ way) <= 0)
    if len(back):
        at = int(back[0]) + 2
        table.fault(
            f"trunks_m[{at}]", "lies behind the tree before", "list the trees as they stand"
        )
    elif way[0] <= 0:
        table.fault("trunks_m", "runs against +x", "list its trees the other way round")


def read_distances(table: Table, first: bool) -> tuple[float, float]:
    """distance_m and far_distance_m; the first row has none."""
    if first:
        return table.number("distance_m", 0, 0, 0.0), table.number("far_distance_m", 0, 0, 0.0)
    distance = table.number("distance_m", 0, 200, above_low=True)
    return distance, table.number("far_distance_m", 0, 200, distance, above_low=True)


def read_start(table: Table, first: bool) -> float:
    """start_m; the first row starts at the origin."""
    reach = 0.0 if first else FARTHEST
    return table.number("start_m", -reach, reach, 0.0)


def read_obstacles(tables: list[Table]) -> list[KnownObstacle]:
    """[[obstacle]]: height_m above its ground_m, which is 0 where it is left out."""
    found = []
    for table in tables:
        at = [table.number(key, -FARTHEST, FARTHEST) for key in ("x_m", "y_m")]
        radius = table.number("radius_m", 0, 20, above_low=True)
        top = table.number("height_m", 0, 200, above_low=True) + table.number(
            "ground_m", -500, 500, 0.0
        )
        name = table.text("name", "pole")
        table.done()
        if np.isfinite([*at, radius, top]).all():
            found.append(KnownObstacle(np.array(at), radius, top, name))
    return found


def read_ring(table: Table) -> np.ndarray:
    """The corners (n, 2) m of [fence] or a [[keep_out]]; empty when they are wrong."""
    ring = np.array(table.points("points_m")).reshape(-1, 2)
    table.done()
    if not len(ring) or not np.isfinite(ring).all():
        return np.empty((0, 2))
    if not shapely.Polygon(ring).is_valid:
        table.faults.append(
            Fault(f"{table.where}: points_m", "the outline crosses itself", "order its corners")
        )
    return ring
