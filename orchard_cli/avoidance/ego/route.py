"""The global trajectory as the method uses it: how far along it we are, and where to aim."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.trajectory import MotionState, Trajectory

_TICK = 0.1  # s between the places that are looked at
_SPAN = 10.0  # s looked ahead at first
_AT_REST = 1e-6  # m between control points
_MEET = 2.0  # s behind the last target in which the nearest place may still lie


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """The local target."""

    progress: float  # s on the reference's clock, of the place nearest to the vehicle
    time: float  # s on the reference's clock, of the target
    state: MotionState
    final: bool  # whether it is the reference's end
    ahead_site: Points  # (n, 3) m, the reference from the nearest place to behind the target


def goals(reference: Trajectory) -> Array:
    """(n,) s: when a reference comes to rest on its way, and its end."""
    apart = np.abs(np.diff(reference.control_points_site, axis=0)).max(axis=1)
    rests = (apart[:-1] < _AT_REST) & (apart[1:] < _AT_REST)  # at each knot
    begins = np.flatnonzero(rests[1:] & ~rests[:-1]) + 1
    begins = begins[~np.array([rests[k:].all() for k in begins], dtype=np.bool_)]
    return np.append(reference.start + begins * reference.interval, reference.end)


def aim(
    reference: Trajectory,
    here_site: Vector,
    progress: float,
    reached: float,
    horizon: float,
    goal: float,
) -> Target:
    """The first place of the reference that is `horizon` m from here, straight, or the goal, s.

    The place nearest to here is looked for between `progress` and a little after `reached`, the
    last target's time, but not behind the goal.
    """
    span = max(_SPAN, reached + _MEET - progress)
    while True:
        ticks = progress + _TICK * np.arange(int(span / _TICK) + 2)
        times = np.asarray(np.minimum(ticks, goal), dtype=np.float64)
        places = reference.sample(times)[0]
        away = np.linalg.norm(places - here_site, axis=1)
        within = int(np.searchsorted(times, reached + _MEET)) + 1
        nearest = int(np.argmin(away[:within]))
        far = np.flatnonzero(away[nearest:] >= horizon)
        final = times[-1] >= goal and len(far) == 0
        if len(far) or final:
            break
        span *= 2
    first = nearest + (int(far[0]) if len(far) else len(times))
    time = goal if final else min(float(times[first]), goal)
    final = time >= reference.end
    return Target(
        float(times[nearest]), time, reference.at(time), final, places[nearest : first + 20]
    )


def onward(reference: Trajectory, target: Target, interval: float) -> Points:
    """Control points (n, 3) of the reference from one interval before the target to its end.

    Knots `interval` apart, one of them at the target: a spline of other knots follows the
    reference with an error of fourth order, here under a millimetre.
    """
    if target.final:
        return np.repeat(reference.at(reference.end).position_site[None], 3, axis=0)
    count = int(np.ceil((reference.end - target.time) / interval)) + 4
    times = np.asarray(target.time + interval * np.arange(-1, count), dtype=np.float64)
    places, _, accelerations = reference.sample(times)
    bent = np.where((times < reference.end)[:, None], accelerations, 0.0)
    points: Points = places - interval**2 / 6 * bent
    return points


def strays(places_site: Points, ahead_site: Points, most: float) -> NDArray[np.intp]:
    """Indices (m,) of the places (n, 3) that are further than `most` m from the reference's."""
    offsets: Array = places_site[:, None, :] - ahead_site[None]
    away = np.sqrt((offsets**2).sum(axis=2).min(axis=1))
    return np.flatnonzero(away > most)
