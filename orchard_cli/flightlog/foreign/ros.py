"""ROS 2 bags in MCAP -> FlownLog: one topic of nav_msgs/Odometry or geometry_msgs/PoseStamped."""

from __future__ import annotations

from array import array
from pathlib import Path
from typing import Any

import numpy as np
from mcap.records import Channel, Schema

from orchard_cli.errors import Fault, InputError
from orchard_cli.flightlog.scan import Raw, Scan
from orchard_cli.geometry.frames import enu_from_site
from orchard_cli.model.arrays import Array
from orchard_cli.model.flown import Commands, FlownLog, Track

ODOMETRY = ("nav_msgs/msg/Odometry", "nav_msgs/Odometry")
POSE = ("geometry_msgs/msg/PoseStamped", "geometry_msgs/PoseStamped")
MOST = 4_000_000  # messages of one topic that are read
_WIDTH = 14  # time, position, velocity, quaternion w x y z, angular velocity


def read_ros(path: Path, topic: str | None, heading: float | None) -> FlownLog:
    """The flight that one topic of a bag tells of.

    `topic`: None takes the only odometry topic, else the only pose topic. `heading`: compass
    heading (rad) of the site's x, when the bag's frame is east, north, up about the site's
    origin; None: it is the site frame. Raises InputError when there is no such topic, or several.
    """
    channels, schemas = _channels(path)
    chosen = _choose(path, channels, schemas, topic)
    scan = Scan(path, [chosen.topic])
    decode = _decoder(path, schemas[chosen.schema_id])
    take = _odometry if schemas[chosen.schema_id].name in ODOMETRY else _pose
    numbers, unread = array("d"), 0
    for record in scan:
        if isinstance(record, Raw) and record.channel_id == chosen.id:
            try:
                numbers.extend(take(decode(record.data)))
            except Exception:  # a damaged message: the decoder raises many kinds
                unread += 1
            if len(numbers) > MOST * _WIDTH:
                raise InputError(Fault(str(path), f"{chosen.topic} is too long to be a flight"))
    table = _ordered(np.frombuffer(numbers).reshape(-1, _WIDTH))
    notes = [f"from {chosen.topic} of a ROS 2 bag: only what its poses tell is measured"]
    if scan.end:
        notes.append(f"read up to the last whole chunk: {scan.end}")
    if unread:
        notes.append(f"{unread} messages of {chosen.topic} cannot be read")
    return _flown(path, table, heading, notes)


def _channels(path: Path) -> tuple[list[Channel], dict[int, Schema]]:
    """All channels and schemas: from everywhere in the file, since a bag may be cut."""
    channels, schemas = {}, {}
    for record in Scan(path):
        if isinstance(record, Channel):
            channels[record.id] = record
        elif isinstance(record, Schema):
            schemas[record.id] = record
    return [one for one in channels.values() if one.schema_id in schemas], schemas


def _choose(
    path: Path, channels: list[Channel], schemas: dict[int, Schema], topic: str | None
) -> Channel:
    def of(names: tuple[str, ...]) -> list[Channel]:
        return [one for one in channels if schemas[one.schema_id].name in names]

    usable = of(ODOMETRY) + of(POSE)
    listed = ", ".join(sorted({one.topic for one in usable})) or "none"
    if topic is not None:
        fitting = [one for one in usable if one.topic == topic]
        if not fitting:
            what = f"has no odometry or pose topic {topic}"
            raise InputError(Fault(str(path), what, f"it has: {listed}"))
        return fitting[0]
    for found in (of(ODOMETRY), of(POSE)):
        if len({one.topic for one in found}) == 1:
            return found[0]
        if found:
            what = "has several odometry or pose topics"
            raise InputError(Fault(str(path), what, f"choose with --topic: {listed}"))
    raise InputError(Fault(str(path), "holds no flight: no odometry and no poses"))


def _decoder(path: Path, schema: Schema) -> Any:
    try:
        from mcap_ros2.decoder import DecoderFactory
    except ImportError:
        mend = "install it: pip install 'orchard-cli[logs]'"
        raise InputError(Fault(str(path), "needs mcap-ros2-support to be read", mend)) from None
    try:
        return DecoderFactory().decoder_for("cdr", schema)
    except Exception as error:  # a damaged schema
        raise InputError(Fault(str(path), f"its schema cannot be read: {error}")) from None


def _odometry(one: Any) -> tuple[float, ...]:
    """The twist of an Odometry is told in the body's frame (REP 105: child_frame_id)."""
    pose, twist = one.pose.pose, one.twist.twist
    return (*_stamped(one.header, pose), *_xyz(twist.linear), *_xyz(twist.angular))


def _pose(one: Any) -> tuple[float, ...]:
    return (*_stamped(one.header, one.pose), *[float("nan")] * 6)


def _stamped(header: Any, pose: Any) -> tuple[float, ...]:
    stamp = header.stamp
    q = pose.orientation
    seconds = stamp.sec + stamp.nanosec * 1e-9
    return (seconds, *_xyz(pose.position), float(q.w), float(q.x), float(q.y), float(q.z))


def _xyz(v: Any) -> tuple[float, float, float]:
    return float(v.x), float(v.y), float(v.z)


def _ordered(table: Array) -> Array:
    """Time first, position, quaternion, body velocity, body rates; in time order, all finite."""
    table = table[np.isfinite(table[:, :8]).all(axis=1)]
    _, first = np.unique(table[:, 0], return_index=True)
    return np.asarray(table[first])


def _flown(path: Path, table: Array, heading: float | None, notes: list[str]) -> FlownLog:
    from scipy.spatial.transform import Rotation

    times, positions, quaternions = table[:, 0], table[:, 1:4], table[:, 4:8]
    upright = np.linalg.norm(quaternions, axis=1) > 1e-6
    quaternions = np.where(upright[:, None], quaternions, [1.0, 0.0, 0.0, 0.0])
    turn = (
        Rotation.identity() if heading is None else Rotation.from_matrix(enu_from_site(heading).T)
    )
    attitude = turn * Rotation.from_quat(quaternions, scalar_first=True)
    positions = turn.apply(positions) if len(positions) else positions
    velocities = attitude.apply(table[:, 8:11]) if len(table) else np.empty((0, 3))
    if len(times) > 1 and not np.isfinite(velocities).all():
        velocities = np.gradient(positions, times, axis=0)
        notes.append("its velocities are the slope of its positions")
    track = Track(
        times, positions, np.nan_to_num(velocities),
        attitude.as_quat(scalar_first=True) if len(table) else np.empty((0, 4)), table[:, 11:14],
    )  # fmt: skip
    none = np.empty((0, 3))
    return FlownLog(
        file=path.name,
        metadata={"system": "ROS 2", "vehicle": "ROS 2", "simulated": "unknown"},
        attachments={},
        odometry=track,
        truth=None,
        commands=Commands(np.empty(0), none, none, none, np.empty(0)),
        battery_times=np.empty(0),
        battery_shares=np.empty(0),
        notes=tuple(notes),
    )
