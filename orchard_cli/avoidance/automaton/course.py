"""Velocity commands as trajectories, and the way back onto the route."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.arrays import Array, Points, Vector
from orchard_cli.model.trajectory import Trajectory
from orchard_cli.motion.join import Join, join_at

INTERVAL = 0.1  # s between knots
STRETCHES = (1.0, 1.25, 1.6, 2.0, 2.6, 3.5, 5.0)  # of the time that the way back takes
SHARE = 0.6  # of the acceleration, for speeding up along the route; the rest is for coming aside


def steered(
    active: Trajectory,
    span: tuple[float, float],
    velocity_site: Vector,
    acceleration: float,
    lasting: float,
) -> Trajectory:
    """Leave `active` for a velocity (3,) m/s, keep it for `lasting` s, then brake to rest.

    `span`: now and the commit time; up to there it equals `active`. Without the next command it
    comes to rest by itself. The acceleration is at most `acceleration` m/s², as a vector.
    """
    join = join_at(active, *span, INTERVAL)
    h, points = join.interval, list(join.points_site)
    flown = (points[-1] - points[-2]) / h
    flown = _slew(points, flown, velocity_site, acceleration * h, h)
    for _ in range(math.ceil(lasting / h)):
        points.append(points[-1] + h * flown)
    _slew(points, flown, np.zeros(3), acceleration * h, h)
    points += [points[-1], points[-1]]
    return Trajectory(join.start, h, np.array(points))


def _slew(points: list[Vector], flown: Vector, wanted: Vector, most: float, h: float) -> Vector:
    """Append points until the velocity is the wanted one, `most` m/s nearer with each."""
    while True:
        change = wanted - flown
        size = float(np.linalg.norm(change))
        flown = wanted if size <= most else flown + change * (most / size)
        points.append(points[-1] + h * flown)
        if size <= most:
            return flown


@dataclass(frozen=True, slots=True, eq=False)
class WayBack:
    """A trajectory that ends on the reference, some seconds late."""

    trajectory: Trajectory
    begin: float  # s, where it leaves the active one
    rejoin: float  # s, from when on it is the reference, delayed
    delay: float  # s


def back_to_route(
    active: Trajectory,
    reference: Trajectory,
    span: tuple[float, float],
    onto: float,
    acceleration: float,
) -> WayBack | None:
    """From the active trajectory onto the reference at its time `onto`, then along it to its end.

    The reference's clock is sped up smoothly from as fast as the vehicle goes to 1, while the
    distance to it fades by a quintic. None when that asks for more than `acceleration` m/s² however
    long it takes.
    """
    join = join_at(active, *span, INTERVAL)
    begin = active.at(join.time)
    there = reference.at(onto)
    speed = float(np.linalg.norm(there.velocity_site))
    rate = 1.0
    if speed > 0.05:
        rate = float(begin.velocity_site @ there.velocity_site) / speed**2
    rate = min(max(rate, 0.0), 1.0)
    gap = (
        begin.position_site - there.position_site,
        begin.velocity_site - rate * there.velocity_site,
        begin.acceleration_site - rate**2 * there.acceleration_site,
    )
    aside = float(np.linalg.norm(gap[0]))
    eased = 1.5 * (1 - rate) * speed / (SHARE * acceleration)
    faded = max(
        math.sqrt(6 * aside / ((1 - SHARE) * acceleration)),
        3 * float(np.linalg.norm(gap[1])) / acceleration,
    )
    for stretch in STRETCHES:
        lasts = (max(eased * stretch, 4 * join.interval), max(faded * stretch, 4 * join.interval))
        made = _faded(join, reference, onto, rate, gap, lasts)
        if _hardest(made.trajectory, join) <= acceleration * 1.02:
            return made
    return None


def _faded(
    join: Join,
    reference: Trajectory,
    onto: float,
    rate: float,
    gap: tuple[Vector, Vector, Vector],
    lasts: tuple[float, float],
) -> WayBack:
    """`lasts`: s until the reference's clock runs at 1, and until the gap is gone."""
    h = join.interval
    last = h * math.ceil(max(lasts) / h)
    reached = onto + _clock(np.array([last]), rate, lasts[0])[0]
    count = math.ceil(max(last + max(reference.end - reached, 0.0), 4 * h) / h) + 3
    times = h * np.arange(-1, count)
    clock = onto + _clock(times, rate, lasts[0])
    places = reference.sample(clock)[0] + _fading(times, gap, lasts[1])
    points = places.copy()
    points[1:-1] -= (places[2:] - 2 * places[1:-1] + places[:-2]) / 6
    control = np.concatenate([join.points_site, points[3:-1], np.repeat(places[-1:], 3, axis=0)])
    rejoin = join.time + last
    return WayBack(Trajectory(join.start, h, control), join.time, rejoin, rejoin - reached)


def _clock(times: Array, rate: float, lasts: float) -> Array:
    """s on the reference's clock after each time: `rate` at first, 1 from `lasts` on."""
    share = np.clip(times / lasts, 0.0, 1.0)
    eased = rate * lasts * share + (1 - rate) * lasts * (share**3 - share**4 / 2)
    outside = np.where(times < 0, rate * times, np.maximum(times - lasts, 0.0))
    return np.asarray(eased + outside)


def _fading(times: Array, gap: tuple[Vector, Vector, Vector], lasts: float) -> Points:
    """The quintic from position, velocity and acceleration to nothing at all: (n, 3) m."""
    p, v, a = gap
    u = np.clip(times / lasts, None, 1.0)[:, None]
    v, a = v * lasts, a * lasts**2
    third = -10 * p - 6 * v - 1.5 * a
    fourth = 15 * p + 8 * v + 1.5 * a
    fifth = -6 * p - 3 * v - 0.5 * a
    faded: Points = p + u * (v + u * (a / 2 + u * (third + u * (fourth + u * fifth))))
    return faded


def _hardest(trajectory: Trajectory, join: Join) -> float:
    """Greatest acceleration after the join, m/s²."""
    bends = np.diff(trajectory.control_points_site[len(join.points_site) - 2 :], n=2, axis=0)
    return float(np.linalg.norm(bends, axis=1).max()) / trajectory.interval**2
