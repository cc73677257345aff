"""OctoMap on the same frames, beside ours: the C++ library by its Python binding `pyoctomap`."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any

import numpy as np

from orchard_cli.errors import Fault, InputError
from orchard_cli.geometry.rotations import matrix
from orchard_cli.model.arrays import Points

from .frames import Seen, Stretch
from .samples import Samples

CELL = 0.1  # m


def binding() -> Any:
    """The module. Raises InputError when it is not installed."""
    try:
        return import_module("pyoctomap")
    except ImportError:
        raise InputError(
            Fault("--octomap", "pyoctomap is not installed", "pip install pyoctomap")
        ) from None


def measure(stretches: Sequence[Stretch], most: int, samples: Samples) -> None:
    """Time `octomap` over at most `most` frames: insertPointCloud of every return within range,
    thinned per cell. Making the points is not counted; the first frame of a stretch neither.
    """
    module = binding()
    for stretch in stretches:
        tree = module.OcTree(CELL)
        for number, seen in enumerate(stretch.seen[: max(most // len(stretches), 2)]):
            points, origin = cloud(seen)
            if number == 0:
                _insert(tree, points, origin)
                continue
            with samples.timed("octomap"):
                _insert(tree, points, origin)


def _insert(tree: Any, points: Points, origin: Points) -> None:
    tree.insertPointCloud(points, origin, discretize=True)


def cloud(seen: Seen) -> tuple[Points, Points]:
    """The returns within range (n, 3) and the optical centre (3,), site frame, m."""
    camera, depth = seen.frame.camera, seen.frame.depth_mm / 1000.0
    v, u = np.nonzero((depth >= camera.range_min) & (depth <= camera.range_max))
    in_camera = camera.points(u, v, depth[v, u])
    site_from_body = matrix(seen.vehicle.site_from_body)
    origin = np.asarray(seen.vehicle.position_site) + site_from_body @ camera.position_body
    return in_camera @ (site_from_body @ camera.body_from_camera).T + origin, origin
