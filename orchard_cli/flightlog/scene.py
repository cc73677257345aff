"""What stands in the orchard as the survey knows it, drawn for Foxglove's 3D panel."""

from __future__ import annotations

import numpy as np
from foxglove import messages as fox

from orchard_cli.flightlog.forms import point, stamp
from orchard_cli.model.arrays import Points
from orchard_cli.model.site import KnownObstacle, Orchard, TreeRow

_GREEN = fox.Color(r=0.25, g=0.5, b=0.25, a=0.6)
_ORANGE = fox.Color(r=0.85, g=0.4, b=0.1, a=0.9)
_LIMIT = fox.Color(r=0.8, g=0.2, b=0.2, a=1.0)
_LEVEL = fox.Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)
_TREE_WIDTH = 0.6  # m; a survey measures no canopy width, so trees are drawn as markers


def scene(orchard: Orchard, utc: int) -> fox.SceneUpdate:
    """Trees, known obstacles, fence and keep-outs as one entity that never ends."""
    rings = [ring for ring in (orchard.fence_site, *orchard.keep_outs_site) if len(ring)]
    entity = fox.SceneEntity(
        timestamp=stamp(utc),
        frame_id="site",
        id=orchard.name,
        cylinders=[c for row in orchard.rows for c in _trees(row)]
        + [_obstacle(obstacle) for obstacle in orchard.obstacles],
        lines=[_ring(ring) for ring in rings],
    )
    return fox.SceneUpdate(entities=[entity])


def _upright(
    x: float, y: float, bottom: float, top: float, width: float, color: fox.Color
) -> fox.CylinderPrimitive:
    centre = fox.Pose(position=point([x, y, (bottom + top) / 2]), orientation=_LEVEL)
    return fox.CylinderPrimitive(
        pose=centre,
        size=fox.Vector3(x=width, y=width, z=top - bottom),
        bottom_scale=1.0,
        top_scale=1.0,
        color=color,
    )


def _trees(row: TreeRow) -> list[fox.CylinderPrimitive]:
    stood = np.column_stack([row.trunks_site, row.ground, row.canopy_tops_site]).tolist()
    return [_upright(x, y, ground, top, _TREE_WIDTH, _GREEN) for x, y, ground, top in stood]


def _obstacle(obstacle: KnownObstacle) -> fox.CylinderPrimitive:
    x, y = (float(v) for v in obstacle.position_site)
    return _upright(x, y, 0.0, float(obstacle.top), 2 * float(obstacle.radius), _ORANGE)


def _ring(ring_site: Points) -> fox.LinePrimitive:
    return fox.LinePrimitive(
        type=fox.LinePrimitiveLineType.LineLoop,
        pose=fox.Pose(position=point([0.0, 0.0, 0.0]), orientation=_LEVEL),
        thickness=0.1,
        points=[fox.Point3(x=x, y=y, z=0.0) for x, y in np.asarray(ring_site).tolist()],
        color=_LIMIT,
    )
