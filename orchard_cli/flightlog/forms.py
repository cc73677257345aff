"""Nouns in the shapes of Foxglove's well-known schemas. Frames: "site", "body", "camera"."""

from __future__ import annotations

import numpy as np
from foxglove import messages as fox
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline as SplineCurve
from scipy.spatial.transform import Rotation

from orchard_cli.geometry.geodesy import wgs84_from_site
from orchard_cli.model.arrays import Points
from orchard_cli.model.depth import DepthCamera, DepthFrame
from orchard_cli.model.mission import Mission
from orchard_cli.model.records import LogLine, NewTrajectory, OccupiedCells
from orchard_cli.model.sensors import ColourFrame
from orchard_cli.model.site import SiteOrigin
from orchard_cli.model.vehicle import VehicleState

LOOK_AHEAD = 20.0
"""s of a trajectory that are drawn; /trajectory/curve has all of it."""

_LEVEL = fox.Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)
_CELL_FIELDS = [
    fox.PackedElementField(name=name, offset=4 * i, type=fox.PackedElementFieldNumericType.Float32)
    for i, name in enumerate(("x", "y", "z", "cell"))
]


def stamp(nanoseconds: int) -> fox.Timestamp:
    """UTC as Foxglove has it."""
    return fox.Timestamp(nanoseconds // 10**9, nanoseconds % 10**9)


def point(values: ArrayLike) -> fox.Vector3:
    """x, y, z."""
    x, y, z = np.asarray(values, dtype=np.float64).tolist()
    return fox.Vector3(x=x, y=y, z=z)


def attitude(quaternion_wxyz: ArrayLike) -> fox.Quaternion:
    """Foxglove orders by name: x, y, z, w."""
    w, x, y, z = np.asarray(quaternion_wxyz, dtype=np.float64).tolist()
    return fox.Quaternion(x=x, y=y, z=z, w=w)


def body_transform(state: VehicleState, utc: int) -> fox.FrameTransforms:
    """Body in site."""
    moved = fox.FrameTransform(
        timestamp=stamp(utc),
        parent_frame_id="site",
        child_frame_id="body",
        translation=point(state.position_site),
        rotation=attitude(state.site_from_body),
    )
    return fox.FrameTransforms(transforms=[moved])


def camera_transform(camera: DepthCamera, utc: int) -> fox.FrameTransforms:
    """Camera in body."""
    mounted = fox.FrameTransform(
        timestamp=stamp(utc),
        parent_frame_id="body",
        child_frame_id="camera",
        translation=point(camera.position_body),
        rotation=attitude(Rotation.from_matrix(camera.body_from_camera).as_quat(scalar_first=True)),
    )
    return fox.FrameTransforms(transforms=[mounted])


def pose(state: VehicleState, utc: int) -> fox.PoseInFrame:
    """The body's pose in the site frame."""
    here = fox.Pose(position=point(state.position_site), orientation=attitude(state.site_from_body))
    return fox.PoseInFrame(timestamp=stamp(utc), frame_id="site", pose=here)


def location(state: VehicleState, origin: SiteOrigin, utc: int) -> fox.LocationFix:
    """Where the estimate stands on the earth; the altitude is as the site's height reference."""
    latitude, longitude, altitude = wgs84_from_site(origin, state.position_site[None])[0]
    return fox.LocationFix(
        timestamp=stamp(utc),
        frame_id="body",
        latitude=float(latitude),
        longitude=float(longitude),
        altitude=float(altitude),
    )


def path(points_site: Points, utc: int) -> fox.PosesInFrame:
    """Points in order, each pose looking along the path."""
    points = np.asarray(points_site, dtype=np.float64).reshape(-1, 3)
    steps = np.diff(points[:, :2], axis=0, append=points[-1:, :2])
    half = np.arctan2(steps[:, 1], steps[:, 0]) / 2
    poses = [
        fox.Pose(
            position=fox.Vector3(x=x, y=y, z=z),
            orientation=fox.Quaternion(x=0.0, y=0.0, z=float(np.sin(a)), w=float(np.cos(a))),
        )
        for (x, y, z), a in zip(points.tolist(), half, strict=True)
    ]
    return fox.PosesInFrame(timestamp=stamp(utc), frame_id="site", poses=poses)


def trajectory_ahead(record: NewTrajectory, utc: int) -> fox.PosesInFrame:
    """The next seconds of a trajectory, five poses a second."""
    curve = record.trajectory
    begin = max(record.time, curve.start)
    end = max(begin, min(curve.end, begin + LOOK_AHEAD))
    positions, _, _ = curve.sample(np.linspace(begin, end, int((end - begin) * 5) + 2))
    return path(positions, utc)


def spline(mission: Mission, utc: int) -> fox.PosesInFrame:
    """The mission's global B-spline, a pose about every half metre."""
    curve = mission.spline
    first, last = curve.knots[curve.degree], curve.knots[-curve.degree - 1]
    at = np.linspace(first, last, int((last - first) * 2) + 2)
    return path(SplineCurve(curve.knots, curve.control_points_site, curve.degree)(at), utc)


def occupied(record: OccupiedCells, utc: int) -> fox.PointCloud:
    """Cell centres as a cloud; the fourth field of each point is the cell's edge in metres."""
    table = np.empty((len(record.centres_site), 4), dtype="<f4")
    table[:, :3] = record.centres_site
    table[:, 3] = record.cell
    return fox.PointCloud(
        timestamp=stamp(utc),
        frame_id="site",
        pose=fox.Pose(position=fox.Vector3(x=0.0, y=0.0, z=0.0), orientation=_LEVEL),
        point_stride=16,
        fields=_CELL_FIELDS,
        data=table.tobytes(),
    )


def depth_image(frame: DepthFrame, utc: int) -> fox.RawImage:
    """Depth in millimetres along the optical axis, little endian; 0: no return."""
    height, width = frame.depth_mm.shape
    return fox.RawImage(
        timestamp=stamp(utc),
        frame_id="camera",
        width=width,
        height=height,
        encoding="16UC1",
        step=2 * width,
        data=np.ascontiguousarray(frame.depth_mm, dtype="<u2").tobytes(),
    )


def colour_image(frame: ColourFrame, utc: int) -> fox.RawImage:
    """Red, green, blue, aligned to the depth image."""
    height, width, _ = frame.rgb.shape
    return fox.RawImage(
        timestamp=stamp(utc),
        frame_id="camera",
        width=width,
        height=height,
        encoding="rgb8",
        step=3 * width,
        data=np.ascontiguousarray(frame.rgb).tobytes(),
    )


def calibration(camera: DepthCamera, utc: int) -> fox.CameraCalibration:
    """A pinhole without distortion."""
    fx, fy, cx, cy = (float(v) for v in (camera.fx, camera.fy, camera.cx, camera.cy))
    return fox.CameraCalibration(
        timestamp=stamp(utc),
        frame_id="camera",
        width=camera.width,
        height=camera.height,
        distortion_model="plumb_bob",
        D=[0.0] * 5,
        K=[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        R=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        P=[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    )


def log_line(line: LogLine, utc: int) -> fox.Log:
    """A sentence, named for the room that says it."""
    level = (fox.LogLevel.Debug, fox.LogLevel.Info, fox.LogLevel.Warning, fox.LogLevel.Error)
    return fox.Log(
        timestamp=stamp(utc),
        level=level[line.severity.value - 1],
        message=line.text,
        name=line.room,
    )
