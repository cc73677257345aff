"""Obstacles over several looks: what was seen once only is not believed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from orchard_cli.model.obstacles import Obstacle

LEARN = 0.25  # share of a new look in what is known, at least
NEAR = 1.0  # m between two looks at the same thing, at most; more when it is wide


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """One thing, seen `looks` times, last at `time`."""

    obstacle: Obstacle
    looks: int
    time: float  # s


def follow(
    tracks: Iterable[Track], seen: Iterable[Obstacle], now: float, forget: float
) -> tuple[Track, ...]:
    """What is known after one more look; what was not seen for `forget` s is gone."""
    left = list(tracks)
    after = []
    for obstacle in seen:
        same = [t for t in left if _same(t.obstacle, obstacle)]
        if not same:
            after.append(Track(obstacle, 1, now))
            continue
        nearest = min(same, key=lambda t: _apart(t.obstacle, obstacle))
        left = [t for t in left if t is not nearest]
        after.append(Track(_blend(nearest, obstacle), nearest.looks + 1, now))
    return (*after, *(t for t in left if now - t.time < forget))


def _apart(a: Obstacle, b: Obstacle) -> float:
    return float(np.hypot(*(a.centre_site - b.centre_site)[:2]))


def _same(a: Obstacle, b: Obstacle) -> bool:
    return _apart(a, b) < max(NEAR, min(a.width, b.width) / 2)


def _blend(track: Track, seen: Obstacle) -> Obstacle:
    """A running mean. A look that the image's edge cuts teaches nothing new about size and place
    of what was seen whole."""
    known = track.obstacle
    if seen.cut and not known.cut:
        return known
    if known.cut and not seen.cut:
        return seen
    gain = max(1.0 / (track.looks + 1), LEARN)
    return replace(
        seen,
        width=known.width + gain * (seen.width - known.width),
        centre_site=known.centre_site + gain * (seen.centre_site - known.centre_site),
        bottom=known.bottom + gain * (seen.bottom - known.bottom),
        top=known.top + gain * (seen.top - known.top),
    )
