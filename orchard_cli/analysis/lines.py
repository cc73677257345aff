"""Horizontal distances to planned lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.interpolate import BSpline as SplineCurve

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.mission import Mission
from orchard_cli.model.trajectory import BSpline, Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Offset:
    """Where points stand relative to a line."""

    distance: Array  # (n,) m, horizontal, to the nearest point of the whole line
    height: Array  # (n,) m, the line's z at that nearest point


class Line:
    """A polyline that points are measured against, by its ground plan."""

    def __init__(self, points_site: Points) -> None:
        """(k, 3) m, k >= 2; steps without length are left out."""
        points = np.asarray(points_site, dtype=np.float64)
        keep = np.append(True, np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1) > 1e-9)
        self._points = points[keep]
        plan = self._points[:, :2]
        self._tree = shapely.STRtree(shapely.linestrings(np.stack([plan[:-1], plan[1:]], axis=1)))

    def offset(self, points_site: Points) -> Offset:
        """Of (n, 3) points; the nearest point of the line counts, wherever along it that is."""
        points = np.asarray(points_site, dtype=np.float64)
        if not len(points):
            return Offset(np.empty(0), np.empty(0))
        places = shapely.points(points[:, :2])
        (_, segment), distance = self._tree.query_nearest(
            places, return_distance=True, all_matches=False
        )
        a, b = self._points[segment], self._points[segment + 1]
        along = b[:, :2] - a[:, :2]
        reach = ((points[:, :2] - a[:, :2]) * along).sum(axis=1) / (along**2).sum(axis=1)
        height = a[:, 2] + np.clip(reach, 0.0, 1.0) * (b[:, 2] - a[:, 2])
        return Offset(np.asarray(distance), np.asarray(height))


def planned(mission: Mission) -> Line:
    """The Π: straight lines between the waypoints."""
    return Line(mission.waypoints_site)


def spline_points(curve: BSpline, spacing: float = 0.1) -> Points:
    """(n, 3) m along the global B-spline."""
    first, last = curve.knots[curve.degree], curve.knots[-curve.degree - 1]
    at = np.linspace(first, last, int((last - first) / spacing) + 2)
    return np.asarray(SplineCurve(curve.knots, curve.control_points_site, curve.degree)(at))


def trajectory_points(curve: Trajectory, start: float, end: float, step: float = 0.1) -> Points:
    """(n, 3) m of a trajectory between two of its times."""
    positions, _, _ = curve.sample(np.linspace(start, end, int((end - start) / step) + 2))
    return positions
