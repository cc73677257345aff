"""A Π of straight legs becomes a smooth curve: rounded corners, then one cubic B-spline.

Liu 2024, §4.1 (eqs. 9-13) fits the spline to the legs themselves; its corners then ring and cut by
whatever the least squares give. Here the corners are rounded first, by a stated cut.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline as ScipySpline
from scipy.interpolate import make_lsq_spline

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.trajectory import DEGREE, BSpline

SPACING = 0.02
"""m between samples of a rounded path."""

RAMP = 0.5
"""Share of a corner's turning in the two ramps of its curvature.

The curvature rises in a straight line, stays, and falls: of all shapes with a given cut and a
given steepness of curvature this has the lowest peak. 0 would be an arc, whose curvature steps
(peak 0.41 / cut at a right angle); 1 two clothoids (peak 0.55 / cut); 0.5 costs 9% more than the
arc and gives ramps that are longer than the spline's knot distance at the usual cut.
"""

REACH = 3.145
"""Cuts from a corner to where its bend begins, at a right angle; sharper bends begin nearer and
slighter ones, which would reach far into the legs, are held to this and cut less."""

_ROUNDS = 10  # of rounding less
_EAGER = 1.2  # times the excess by which a corner's cut is lowered
_MORE = 1e-3  # m, besides
_LEAST = 0.05  # of the cut: corners are never rounded less than this
_STRAIGHT = 1e-6  # rad: less is no corner
_PARALLEL = 0.7  # cosine: legs so much against each other make a turn back
_REVERSAL = math.radians(179.0)  # a sharper turn comes back on its own leg and cannot be rounded


@dataclass(frozen=True, slots=True, eq=False)
class RoundedPath:
    """Straight legs with their corners rounded."""

    points_site: Points  # (m, 3) m, at most SPACING apart
    cuts: Array  # (n - 2,) m, from each corner to the curve
    corner_lengths: Array  # (n - 2,) m along the points to where each corner is passed
    total: float  # m along all points


def rounded(corners_site: Points, cut: float | Array, merge: bool = False) -> RoundedPath:
    """Round each inner corner of the legs between (n, 3) points; `cut` may differ: (n - 2,) m.

    The curve passes each corner at `cut` m or nearer: nearer where the turn is slight, or where the
    legs are too short to hold the bend (each gives half of its length to either corner). It leaves
    the legs no farther than REACH cuts from a corner. With `merge`, two corners that make one turn
    back on a leg too short for their bends become one bend of one curvature: wider, so faster.
    Raises ValueError for repeated points, a turn straight back, or a cut that is not positive.
    """
    corners = np.asarray(corners_site, dtype=np.float64)
    legs = np.diff(corners, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    asked = np.broadcast_to(cut, len(corners) - 2)
    if not (asked > 0).all() or not (lengths > 1e-6).all():
        raise ValueError("a path to round needs a positive cut and corners that differ")
    ways = legs / lengths[:, None]
    rooms = _rooms(ways, lengths, asked, merge)
    pieces, cuts, middles, last = [], [], [], corners[0]
    for i in range(1, len(corners) - 1):
        blend, depth = _blend(ways[i - 1], ways[i], float(asked[i - 1]), rooms[i - 1])
        blend = blend + corners[i]
        pieces += [_straight(last, blend[0]), blend[:-1]]
        cuts.append(depth)
        apex = int(np.argmin(np.linalg.norm(blend - corners[i], axis=1)))
        middles.append(sum(map(len, pieces)) - len(blend) + 1 + apex)
        last = blend[-1]
    pieces += [_straight(last, corners[-1]), corners[-1:]]
    points = np.concatenate(pieces)
    along = lengths_of(points)
    passed = along[np.array(middles, dtype=int)]
    return RoundedPath(points, np.array(cuts), passed, float(along[-1]))


def _straight(start: Array, end: Array) -> Points:
    """Samples from start up to, but without, end."""
    n = math.ceil(float(np.linalg.norm(end - start)) / SPACING - 1e-9)
    return start + (end - start) * (np.arange(n) / max(n, 1))[:, None]


@dataclass(frozen=True, slots=True)
class _Room:
    """What a bend may take of the legs before and behind its corner, and which ramps it has."""

    before: float  # m
    behind: float  # m
    rises: bool = True  # False: it goes on from a bend of the same curvature
    falls: bool = True  # False: it goes on into one

    def held(self, into: Array, out: Array, cut: float) -> bool:
        """Whether it is the legs, not the cut, that limit the bend."""
        before, behind, depth = _extent_of((into, out), self.rises, self.falls)
        scale = min(self.before / before, self.behind / behind)
        return scale * depth <= cut and scale * max(before, behind) <= REACH * cut


def _rooms(ways: Points, lengths: Array, cuts: Array, merge: bool) -> list[_Room]:
    """The room of each corner: half of an inner leg, all of an outer one."""
    halves = np.concatenate([[lengths[0]], lengths[1:-1] / 2, [lengths[-1]]])
    rooms = [_Room(float(a), float(b)) for a, b in pairwise(halves)]
    if not merge:
        return rooms
    corners = [(ways[i], ways[i + 1]) for i in range(len(ways) - 1)]
    for i, (first, second) in enumerate(pairwise(corners)):
        if not rooms[i].rises or not _turn_back(first, second):
            continue
        behind = _extent_of(first, falls=False)[1]
        share = behind / (behind + _extent_of(second, rises=False)[0])  # of the same curvature
        leg = float(lengths[i + 1])
        one = replace(rooms[i], behind=share * leg, falls=False)
        other = replace(rooms[i + 1], before=(1 - share) * leg, rises=False)
        if one.held(*first, cuts[i]) and other.held(*second, cuts[i + 1]):
            rooms[i], rooms[i + 1] = one, other
    return rooms


def _turn_back(first: tuple[Array, Array], second: tuple[Array, Array]) -> bool:
    """Whether two corners one after the other turn the same way, back to where they came from."""
    (into, between), (_, out) = first, second
    same = float(np.cross(into, between) @ np.cross(between, out)) > 0
    return same and float(into @ out) < -_PARALLEL


def _angle(into: Array, out: Array) -> float:
    return 2 * math.asin(min(1.0, float(np.linalg.norm(out - into)) / 2))


def _blend(into: Array, out: Array, cut: float, room: _Room) -> tuple[Points, float]:
    """The bend at a corner in the origin from direction `into` to `out`, and its depth in m."""
    angle = _angle(into, out)
    if angle < _STRAIGHT:
        return np.zeros((1, 3)), 0.0
    if angle > _REVERSAL:
        raise ValueError("a turn straight back cannot be rounded")
    before, behind, depth = _extent_of((into, out), room.rises, room.falls)
    reach = REACH * cut
    scale = min(cut / depth, min(room.before, reach) / before, min(room.behind, reach) / behind)
    count = max(9, math.ceil(scale * (1 + RAMP) * angle / SPACING) + 1) | 1
    flat = scale * (_unit_bend(angle, count, room.rises, room.falls) - [before, 0.0])
    left = out - into * float(into @ out)
    left = left / np.linalg.norm(left)
    return flat[:, :1] * into + flat[:, 1:] * left, scale * depth


def _extent_of(
    corner: tuple[Array, Array], rises: bool = True, falls: bool = True
) -> tuple[float, float, float]:
    """m that a bend of peak curvature 1 takes of the legs before and behind its corner, and its
    least distance from it."""
    angle = _angle(*corner)
    unit = _unit_bend(angle, 201, rises, falls)
    behind = float(unit[-1, 1]) / math.sin(angle)
    before = float(unit[-1, 0]) - behind * math.cos(angle)
    depth = float(np.linalg.norm(unit - [before, 0.0], axis=1).min())
    return before, behind, depth


def _unit_bend(angle: float, count: int, rises: bool = True, falls: bool = True) -> Points:
    """Samples (count, 2) of a bend by `angle` rad with peak curvature 1 from the origin along +x.

    `count` is odd. Its curvature is a trapezoid: ramps of RAMP angle, a plateau between them; a
    ramp may be left out.
    """
    up, down = RAMP * angle * rises, RAMP * angle * falls
    total = angle + (up + down) / 2
    s = np.linspace(0.0, total, 4 * (count - 1) + 1)
    rising = np.minimum(s, up) ** 2 / (2 * up) if rises else 0.0 * s
    falling = np.maximum(s - (total - down), 0.0) ** 2 / (2 * down) if falls else 0.0 * s
    heading = rising + np.maximum(s - up, 0.0) - falling
    ways = np.column_stack([np.cos(heading), np.sin(heading)])
    # Simpson's rule over pairs of the fine steps
    h = total / (2 * (count - 1))
    pairs = (ways[0:-2:2] + 4 * ways[1:-1:2] + ways[2::2]) * h / 6
    return np.concatenate([np.zeros((1, 2)), np.cumsum(pairs, axis=0)])[::2]


def fit_spline(path_site: Points, count: int) -> BSpline:
    """Least-squares clamped cubic B-spline with `count` control points (Liu 2024, eqs. 9-13).

    `path_site` (m, 3) m are dense samples of a smooth path; the parameter is its length. The
    spline starts and ends on the path's ends. Raises ValueError with fewer than four points.
    """
    path = np.asarray(path_site, dtype=np.float64)
    if count < DEGREE + 1:
        raise ValueError("a cubic spline needs four control points")
    lengths = lengths_of(path)
    inner = np.linspace(0.0, lengths[-1], count - DEGREE + 1)
    knots = np.concatenate([np.zeros(DEGREE), inner, np.full(DEGREE, lengths[-1])])
    weights = np.ones(len(path))
    weights[[0, -1]] = 1e4
    # the default, QR, takes time with the square of `count`; the normal equations are well enough
    # conditioned here to agree with it to the last digits
    fitted = make_lsq_spline(lengths, path, knots, k=DEGREE, w=weights, method="norm-eq")
    control = np.array(fitted.c)
    control[[0, -1]] = path[[0, -1]]
    return BSpline(DEGREE, knots, control)


def fit_rounded(corners_site: Points, cut: float, count: int) -> tuple[RoundedPath, BSpline]:
    """Round corners (n, 3) m and fit a spline that passes each of them at `cut` m or nearer.

    The spline smooths what is sharper than its knots are apart, and so leaves sharp corners
    farther than the path that it is fitted to: those are rounded less until it keeps the cut. With
    knots 0.5 m apart it does for cuts from 0.2 m; for less, measure.
    """
    corners = np.asarray(corners_site, dtype=np.float64)
    cuts = np.full(len(corners) - 2, cut)
    for _ in range(_ROUNDS):
        path = rounded(corners, cuts, merge=True)
        spline = fit_spline(path.points_site, count)
        over = distances(corners[1:-1], samples(spline)) - cut
        if (over <= 0).all():
            break
        cuts = np.maximum(cuts - (over > 0) * (_EAGER * over + _MORE), _LEAST * cut)
    return path, spline


def evaluate(spline: BSpline, parameters: Array) -> Points:
    """Points (m, 3) m of a spline at (m,) parameters, eq. 9."""
    curve = ScipySpline(spline.knots, spline.control_points_site, spline.degree)
    return np.asarray(curve(parameters), dtype=np.float64)


def samples(spline: BSpline) -> Points:
    """Points (m, 3) m of the whole spline, SPACING or less apart in its parameter."""
    end = float(spline.knots[-1])
    return evaluate(spline, np.linspace(0.0, end, math.ceil(end / SPACING) + 1))


def distances(points_site: Points, curve_site: Points) -> Array:
    """Distance of each point (n, 3) to a polyline (m, 3): (n,) m."""
    start, way = curve_site[:-1], np.diff(curve_site, axis=0)
    squared = np.maximum((way**2).sum(axis=1), 1e-18)
    out = np.empty(len(points_site))
    for i, point in enumerate(points_site):
        share = np.clip(((point - start) * way).sum(axis=1) / squared, 0.0, 1.0)
        out[i] = np.linalg.norm(start + share[:, None] * way - point, axis=1).min()
    return out


def lengths_of(path: Points) -> Array:
    """Length of a polyline (m, 3) up to each of its points: (m,) m."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
