"""Readings of two sensors at one time (Huang 2021, §2.2.2, Fig. 3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orchard_cli.model.sensors import ColourFrame, RadarScan


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """An image, and the radar scan nearest to it in time."""

    scan: RadarScan
    image: ColourFrame


def pair(
    scans: Sequence[RadarScan],
    images: Sequence[ColourFrame],
    trigger: float,
    apart: float,
    since: float = -np.inf,
) -> tuple[Pair, ...]:
    """Each image after `since` with its scan, oldest first: the slower sensor's clock counts.

    Published are 90 Hz and 30 Hz, so that the two are at most 1/180 s apart. `apart` s is the most
    that is allowed; `trigger` m is the set safe distance: an image is taken only when something is
    that near. Scans and images come in the order of their times.
    """
    times = np.array([scan.time for scan in scans])
    found = []
    for image in images:
        if image.time <= since or len(times) == 0:
            continue
        nearest = int(np.argmin(np.abs(times - image.time)))
        scan = scans[nearest]
        if abs(scan.time - image.time) > apart:
            continue
        if len(scan.returns) and scan.returns[:, 0].min() <= trigger:
            found.append(Pair(scan, image))
    return tuple(found)
