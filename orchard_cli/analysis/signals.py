"""Statistics over time and derived rates, the same for every metric."""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import solve_banded

from orchard_cli.model.arrays import Array, Points
from orchard_cli.model.flown import Track

CUTOFF = 1.0
"""Hz of the low-pass before differentiating or adding up steps: sensor noise is no motion."""

MOST = 10
"""Evenly spaced samples for each logged one, at most: a log may have gaps of any length."""


def shares(times: Array) -> Array:
    """(n,) share of the whole time that each sample stands for (trapezoid rule); sums to 1."""
    if len(times) == 1:
        return np.ones(1)
    gaps = np.diff(times)
    weights = (np.append(gaps, 0.0) + np.insert(gaps, 0, 0.0)) / 2
    return np.asarray(weights / weights.sum())


def mean(times: Array, values: Array) -> float:
    """Mean over time, not over samples."""
    return float(shares(times) @ values)


def rms(times: Array, values: Array) -> float:
    """Root of the mean square over time."""
    return float(np.sqrt(shares(times) @ values**2))


def percentile_95(times: Array, values: Array) -> float:
    """The value not exceeded during 95 % of the time."""
    weights = shares(times)
    return float(np.quantile(values, 0.95, weights=weights, method="inverted_cdf"))


def smooth(times: Array, values: Points, steady_ends: bool = False) -> tuple[Array, Points]:
    """Evenly spaced times and the values there, low-passed without delay.

    Second-order Butterworth at CUTOFF, forwards and backwards, at the median sampling rate.
    Beyond the log's ends the values are taken to go on as they came (odd extension), or, with
    `steady_ends`, to stay what they are (even), lest noise there looks like a step.
    Fewer than ten samples, or samples slower than twice CUTOFF, are only spaced evenly.
    """
    step = float(np.median(np.diff(times))) if len(times) > 1 else 1.0
    count = min((times[-1] - times[0]) / step, MOST * len(times))
    even = np.linspace(times[0], times[-1], max(2, round(count) + 1))
    spaced = np.column_stack([np.interp(even, times, column) for column in values.T])
    rate = (len(even) - 1) / max(float(even[-1] - even[0]), 1e-9)
    if len(even) < 10 or rate <= 2 * CUTOFF:
        return even, spaced
    pad = min(len(even) - 1, int(3 * rate / CUTOFF))
    before, after = spaced[pad:0:-1], spaced[-2 : -2 - pad : -1]
    if not steady_ends:
        before, after = 2 * spaced[0] - before, 2 * spaced[-1] - after
    extended = np.concatenate([before, spaced, after])
    there = _low_passed(extended, rate)
    back = _low_passed(there[::-1], rate)[::-1]
    return even, np.ascontiguousarray(back[pad : pad + len(even)])


def _low_passed(values: Points, rate: float) -> Points:
    """Second-order Butterworth at CUTOFF of (n, m) samples, as if the first had been so for ever.

    SciPy's `signal` does the same (the tests compare them), and to import it takes longer than to
    read a log. The recursion y + a1 y' + a2 y'' = b (x + 2 x' + x'') is a banded system.
    """
    k = math.tan(math.pi * CUTOFF / rate)
    scale = 1 / (1 + math.sqrt(2) * k + k * k)
    b, a1, a2 = k * k * scale, 2 * (k * k - 1) * scale, (1 - math.sqrt(2) * k + k * k) * scale
    past = np.concatenate([values[:1], values[:1], values])
    right = b * (past[2:] + 2 * past[1:-1] + past[:-2])
    right[0] -= (a1 + a2) * values[0]
    right[1] -= a2 * values[0]
    bands = np.repeat([[1.0], [a1], [a2]], len(values), axis=1)
    return np.asarray(solve_banded((2, 0), bands, right))


def path_length(track: Track) -> float:
    """m along the low-passed positions."""
    _, positions = smooth(track.times, track.positions_site)
    return float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())


def accelerations(track: Track) -> tuple[Array, Array]:
    """Times and the size of the flown acceleration (m/s²): the slope of low-passed velocity."""
    times, velocities = smooth(track.times, track.velocities_site, steady_ends=True)
    slope = np.gradient(velocities, times, axis=0)
    return times, np.linalg.norm(slope, axis=1)


def yaws(track: Track) -> Array:
    """(n,) rad, the nose's angle from +x, without jumps at the wrap."""
    w, x, y, z = track.site_from_body.T
    return np.unwrap(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def yaw_rates(track: Track) -> tuple[Array, Array]:
    """Times and the yaw angle's rate (rad/s), counter-clockwise positive.

    From the angular velocity, q sin(roll) / cos(pitch) + r cos(roll) / cos(pitch); where the log
    lacks it, the slope of the low-passed yaw angle.
    """
    rates = track.angular_velocities_body
    if len(track.times) and np.isfinite(rates).all():
        w, x, y, z = track.site_from_body.T
        roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        level = np.maximum(np.sqrt(np.clip(1 - (2 * (w * y - x * z)) ** 2, 0.0, 1.0)), 0.1)
        turned = (rates[:, 1] * np.sin(roll) + rates[:, 2] * np.cos(roll)) / level
        return track.times, np.asarray(turned)
    times, angles = smooth(track.times, yaws(track)[:, None])
    return times, np.gradient(angles[:, 0], times)
