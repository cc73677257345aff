"""A path becomes a trajectory: how fast to go where, under the vehicle's limits.

Three steps, each of which keeps what the one before has promised:

1. Forward and backward passes give the fastest speed along the path whose acceleration, along the
   path and across it together, keeps the limit (the classic time law of path-following robots).
2. A moving average over EASE seconds makes the acceleration continuous. An average of speeds and
   accelerations that keep a limit keeps it too; so that this holds where the path bends, each
   point first takes the tightest bend that lies within the average's reach.
3. The cubic B-spline's control points are taken from samples of that motion by the local
   quasi-interpolant (f - Δ²f/6), which is fourth-order exact and, unlike interpolation, does not
   ring. Where the spline still exceeds a limit, that limit is lowered and the steps repeated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.mission import Limits
from orchard_cli.model.trajectory import Trajectory

STEP = 0.05
"""m: chords of the path longer than this are straight; sample smooth curves at least so densely."""

EASE = 1.0
"""s over which a change of acceleration is spread; at least two knot intervals."""

TOLERANCE = 0.01
"""Share by which a trajectory may exceed a limit: the spline only approximates the time law."""

CRUISE = 0.93
"""Share of the speed limit that is planned: flown speeds exceed the plan by 0.1 m/s at times."""

EFFORT = 0.56
"""Share of the acceleration limit that is planned: flown ones exceed it by 0.2 m/s² at times."""

_ROUNDS = 30  # of lowering the law's limits until the spline keeps its own
_EAGER = 1.3  # power of the excess by which a limit is lowered
_TICK = 0.01  # s, resolution of the average and of the check
_STEEP = 1e-6  # m: a chord with less horizontal length has no heading
_CREEP = 0.05  # m/s: slower than this is turning on the spot


@dataclass(frozen=True, slots=True)
class PathLimits:
    """How fast a path may be flown. The trajectory keeps each within TOLERANCE."""

    speed: float  # m/s
    acceleration: float  # m/s², length of the whole vector
    acceleration_along: float  # m/s², the part along the path
    yaw_rate: float  # rad/s, of the direction of travel seen from above
    climb_speed: float  # m/s, up or down

    @classmethod
    def of(cls, limits: Limits) -> PathLimits:
        """The part of a vehicle's limits that shapes a time law."""
        return cls(**{name: getattr(limits, name) for name in cls.__slots__})

    @classmethod
    def planned(cls, limits: Limits) -> PathLimits:
        """What a time law is made for: below the limits by what sensor noise and tracking add."""
        return replace(
            cls.of(limits),
            speed=CRUISE * limits.speed,
            acceleration=EFFORT * limits.acceleration,
        )


@dataclass(frozen=True, slots=True, eq=False)
class TimedPath:
    """A trajectory along a path, and when it passes where. It starts and ends at rest."""

    trajectory: Trajectory
    lengths: Array  # (n,) m along the path, increasing
    times: Array  # (n,) s, trajectory time at each length

    def time_at(self, length: float) -> float:
        """When the trajectory has come `length` m along the path, s."""
        return float(np.interp(length, self.lengths, self.times))


@dataclass(frozen=True, slots=True, eq=False)
class _Law:
    """Speed over path length: between neighbours the acceleration along the path is constant."""

    lengths: Array  # (n,) m
    speeds: Array  # (n,) m/s
    times: Array  # (n,) s


def time_path(path_site: Points, limits: PathLimits, interval: float | None = None) -> TimedPath:
    """Time law of a path (n, 3) m: from rest at its first point to rest at its last.

    `interval` is the trajectory's knot interval, s; by default 0.5 m of travel at full speed
    (Liu 2024, §4.1). A smooth path, sampled every STEP or denser, is followed within 2 cm and
    within all limits. At a sharp corner the vehicle all but stops and its direction turns at once,
    beyond any yaw rate: round it first (`fit.rounded`). `over_limits` tells how a trajectory does.
    Raises ValueError for a path without length or a limit that is not positive.
    """
    _demand_positive(limits)
    knot = 0.5 / limits.speed if interval is None else interval
    ease = max(EASE, 2 * knot)
    points, lengths = _subdivided(path_site)
    bends = _Bends.of(points, lengths)
    aim = limits
    for _ in range(_ROUNDS):
        fastest = _fastest(lengths, bends, aim)
        law = _fastest(lengths, bends.widened(fastest.times, ease / 2), aim)
        timed = _spline(points, law, knot, ease)
        over = over_limits(timed.trajectory, limits)
        if max(over.values()) <= 1 + TOLERANCE / 2:  # the rest is for rounding in files
            break
        aim = PathLimits(
            **{name: getattr(aim, name) / max(1, share) ** _EAGER for name, share in over.items()}
        )
    return timed


def over_limits(trajectory: Trajectory, limits: PathLimits) -> dict[str, float]:
    """What a trajectory does at most, sampled every 10 ms, as a share of each limit by name."""
    done = peaks(trajectory)
    return {name: getattr(done, name) / getattr(limits, name) for name in PathLimits.__slots__}


def peaks(trajectory: Trajectory) -> PathLimits:
    """The limits that a trajectory just keeps, sampled every 10 ms.

    The yaw rate counts where the vehicle moves at 0.05 m/s or more.
    """
    times = np.arange(trajectory.start, trajectory.end, _TICK)
    _, v, a = trajectory.sample(times)
    speed = np.linalg.norm(v, axis=1)
    along = np.abs((v * a).sum(axis=1)) / np.maximum(speed, 1e-9)
    flat = np.hypot(v[:, 0], v[:, 1])
    turn = np.abs(v[:, 0] * a[:, 1] - v[:, 1] * a[:, 0]) / np.maximum(flat, _CREEP) ** 2
    return PathLimits(
        speed=float(speed.max()),
        acceleration=float(np.linalg.norm(a, axis=1).max()),
        acceleration_along=float(along.max()),
        yaw_rate=float(np.where(flat >= _CREEP, turn, 0.0).max()),
        climb_speed=float(np.abs(v[:, 2]).max()),
    )


def _spline(points: Points, law: _Law, knot: float, ease: float) -> TimedPath:
    """The eased law as a B-spline; two intervals of standing before it make its start exact."""
    times, travelled = _eased(law, ease, rest=2 * knot)
    count = int(np.ceil(times[-1] / knot)) + 6
    at = np.interp((np.arange(count) - 1) * knot, times, travelled)
    samples = np.column_stack([np.interp(at, law.lengths, axis) for axis in points.T])
    padded = np.concatenate([samples[:1], samples, samples[-1:]])
    control = samples - (padded[:-2] - 2 * samples + padded[2:]) / 6
    passed = np.interp(law.lengths, travelled, times)
    return TimedPath(Trajectory(0.0, knot, control), law.lengths, passed)


def _demand_positive(limits: PathLimits) -> None:
    for name in PathLimits.__slots__:
        if not getattr(limits, name) > 0:
            raise ValueError(f"{name} must be positive")


def _subdivided(path_site: Points) -> tuple[Points, Array]:
    """The path without repeated points and with chords of at most STEP, and its lengths."""
    path = np.asarray(path_site, dtype=np.float64)
    chords = np.linalg.norm(np.diff(path, axis=0), axis=1)
    path = path[np.concatenate([[True], chords > 1e-9])]
    if len(path) < 2:
        raise ValueError("a path without length has no time law")
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    longest = min(STEP, lengths[-1] / 8)
    parts = np.maximum(1, np.ceil(np.diff(lengths) / longest - 1e-9)).astype(int)
    dense = np.concatenate(
        [
            start + (end - start) * np.arange(n) / n
            for start, end, n in zip(lengths[:-1], lengths[1:], parts, strict=True)
        ]
        + [lengths[-1:]]
    )
    points = np.column_stack([np.interp(dense, lengths, axis) for axis in path.T])
    return points, dense


@dataclass(frozen=True, slots=True, eq=False)
class _Bends:
    """What the path's shape allows at each point."""

    curvature: Array  # (n,) 1/m
    turning: Array  # (n,) rad of heading per metre of path
    slope: Array  # (n,) metres of height per metre of path

    @staticmethod
    def of(points: Points, lengths: Array) -> _Bends:
        """Bends from the angles between neighbouring chords, each spread over half of both."""
        chords = np.diff(points, axis=0)
        ds = np.diff(lengths)
        reach = (ds[:-1] + ds[1:]) / 2
        units = chords / ds[:, None]
        angles = 2 * np.arcsin(np.clip(np.linalg.norm(np.diff(units, axis=0), axis=1) / 2, 0, 1))
        flat = np.hypot(chords[:, 0], chords[:, 1]) > _STEEP
        headings = np.arctan2(chords[:, 1], chords[:, 0])
        turns = np.abs(np.angle(np.exp(1j * np.diff(headings))))
        turns = np.where(flat[:-1] & flat[1:], turns, 0.0)
        slope = np.abs(units[:, 2])
        return _Bends(
            np.pad(angles / reach, 1, mode="edge"),
            np.pad(turns / reach, 1, mode="edge"),
            np.maximum(np.append(slope, slope[-1]), np.append(slope[0], slope)),
        )

    def widened(self, times: Array, reach: float) -> _Bends:
        """At each point the tightest bend that lies within `reach` seconds of it."""
        first = np.searchsorted(times, times - reach, side="left")
        last = np.searchsorted(times, times + reach, side="right")

        spans = np.column_stack([first, last]).ravel()

        def widest(values: Array) -> Array:
            """Greatest value of each [first, last); the added 0 lets a span end at the end."""
            within: Array = np.maximum.reduceat(np.append(values, 0.0), spans)[::2]
            return within

        return _Bends(widest(self.curvature), widest(self.turning), widest(self.slope))


def _fastest(lengths: Array, bends: _Bends, limits: PathLimits) -> _Law:
    """The fastest law from rest to rest: forwards, then backwards."""
    whole = limits.acceleration
    along = min(limits.acceleration_along, whole)
    tiny = 1e-12
    cap = np.full(len(lengths), limits.speed)
    cap = np.minimum(cap, limits.yaw_rate / np.maximum(bends.turning, tiny))
    cap = np.minimum(cap, limits.climb_speed / np.maximum(bends.slope, tiny))
    cap = np.minimum(cap, np.sqrt(whole / np.maximum(bends.curvature, tiny)))
    squared = cap**2
    squared[[0, -1]] = 0.0
    ds = np.diff(lengths)
    _accelerate(squared, ds, bends.curvature, whole, along)
    _accelerate(squared[::-1], ds[::-1], bends.curvature[::-1], whole, along)
    speeds = np.sqrt(squared)
    times = np.concatenate([[0.0], np.cumsum(2 * ds / (speeds[:-1] + speeds[1:]))])
    return _Law(lengths, speeds, times)


def _accelerate(squared: Array, ds: Array, curvature: Array, whole: float, along: float) -> None:
    """Lower the squared speeds, in place, to what can be reached from the point before."""
    for i in range(len(ds)):
        across = curvature[i] * squared[i]
        spare = max(whole * whole - across * across, 0.0) ** 0.5
        squared[i + 1] = min(squared[i + 1], squared[i] + 2 * min(along, spare) * ds[i])


def _eased(law: _Law, ease: float, rest: float) -> tuple[Array, Array]:
    """Times and travelled lengths, (m,) s and (m,) m, of the law averaged over `ease` s.

    The vehicle stands for `rest` s before it moves. The average is the difference of the travel's
    integral at both ends of the window.
    """
    wide = ease / 2 + _TICK
    ticks = np.arange(-wide, law.times[-1] + wide + _TICK, _TICK)
    moving = np.clip(ticks, 0.0, law.times[-1])
    k = np.clip(np.searchsorted(law.times, moving, side="right") - 1, 0, len(law.times) - 2)
    since = moving - law.times[k]
    gain = np.diff(law.speeds) / np.diff(law.times)
    travelled = law.lengths[k] + since * (law.speeds[k] + gain[k] * since / 2)
    integral = np.concatenate([[0.0], np.cumsum((travelled[1:] + travelled[:-1]) / 2 * _TICK)])
    end = law.lengths[-1]

    def integral_at(times: Array) -> Array:
        beyond = np.maximum(times - ticks[-1], 0.0)  # standing at the end adds `end` per second
        at: Array = np.interp(times, ticks, integral) + end * beyond
        return at

    times = np.arange(-ease / 2, law.times[-1] + ease / 2 + _TICK, _TICK)
    eased = (integral_at(times + ease / 2) - integral_at(times - ease / 2)) / ease
    eased = np.clip(np.maximum.accumulate(eased), 0.0, end)
    eased[-1] = end
    return times + ease / 2 + rest, eased
