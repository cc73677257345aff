"""Obstacles over several looks: what was seen once only is not believed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from orchard_cli.model.obstacles import Category, Obstacle

LEARN = 0.25  # share of a new look in what is known, at least
NEAR = 1.0  # m between two looks at the same thing, at most; more when it is wide


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """One thing, last seen at `time`, and how often it was taken for what."""

    obstacle: Obstacle
    votes: Mapping[Category, int]
    time: float  # s

    @property
    def looks(self) -> int:
        """How often it was seen."""
        return sum(self.votes.values())


def follow(
    tracks: Iterable[Track], seen: Iterable[Obstacle], now: float, forget: float
) -> tuple[Track, ...]:
    """What is known after one more look; what was not seen for `forget` s is gone."""
    left = list(tracks)
    after = []
    for obstacle in seen:
        same = [t for t in left if _same(t.obstacle, obstacle)]
        if not same:
            after.append(Track(obstacle, {obstacle.category: 1}, now))
            continue
        nearest = min(same, key=lambda t: _apart(t.obstacle, obstacle))
        left = [t for t in left if t is not nearest]
        votes = dict(nearest.votes)
        votes[obstacle.category] = votes.get(obstacle.category, 0) + 1
        after.append(Track(_blend(nearest, obstacle, votes), votes, now))
    return (*after, *(t for t in left if now - t.time < forget))


def _apart(a: Obstacle, b: Obstacle) -> float:
    return float(np.hypot(*(a.centre_site - b.centre_site)[:2]))


def _same(a: Obstacle, b: Obstacle) -> bool:
    return _apart(a, b) < max(NEAR, min(a.width, b.width) / 2)


def _blend(track: Track, seen: Obstacle, votes: Mapping[Category, int]) -> Obstacle:
    """A running mean of the looks that took it for what most of them do.

    A look that the image's edge cuts teaches nothing new about size and place of what was seen
    whole.
    """
    known, most = track.obstacle, max(votes, key=lambda category: votes[category])
    if seen.category is not most:
        return known
    if known.category is not most or (known.cut and not seen.cut):
        return seen
    if seen.cut and not known.cut:
        return known
    gain = max(1.0 / (votes[most] + 1), LEARN)
    return replace(
        seen,
        width=known.width + gain * (seen.width - known.width),
        centre_site=known.centre_site + gain * (seen.centre_site - known.centre_site),
        bottom=known.bottom + gain * (seen.bottom - known.bottom),
        top=known.top + gain * (seen.top - known.top),
    )
