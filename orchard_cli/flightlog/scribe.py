"""Which record goes to which topic, in which form, and how often."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
from foxglove import Channel, Context, channels

from orchard_cli.flightlog import forms, messages
from orchard_cli.flightlog.json_forms import json_form
from orchard_cli.flightlog.messages import known, known_vector, vector
from orchard_cli.flightlog.pace import Pace, Rates
from orchard_cli.flightlog.scene import scene
from orchard_cli.model.depth import DepthFrame
from orchard_cli.model.records import (
    LogLine,
    NewTrajectory,
    OccupiedCells,
    PlannerRecord,
    RunHeader,
    SafetyRecord,
    SprayRecord,
    TruthRecord,
)
from orchard_cli.model.sensors import ColourFrame, SensorScan
from orchard_cli.model.vehicle import Setpoint, VehicleState

SCHEMA = "orchard-log/1"

FOXGLOVE_TOPICS = {
    "/tf": channels.FrameTransformsChannel,
    "/pose": channels.PoseInFrameChannel,
    "/gps": channels.LocationFixChannel,
    "/plan/waypoints": channels.PosesInFrameChannel,
    "/plan/spline": channels.PosesInFrameChannel,
    "/trajectory": channels.PosesInFrameChannel,
    "/guide_path": channels.PosesInFrameChannel,
    "/map/occupied": channels.PointCloudChannel,
    "/camera/depth": channels.RawImageChannel,
    "/camera/colour": channels.RawImageChannel,
    "/camera/calibration": channels.CameraCalibrationChannel,
    "/scene": channels.SceneUpdateChannel,
    "/log": channels.LogChannel,
}
"""Topics in Foxglove's own schemas."""

TimedRecord = (
    VehicleState
    | Setpoint
    | DepthFrame
    | SensorScan
    | LogLine
    | PlannerRecord
    | SafetyRecord
    | SprayRecord
    | TruthRecord
    | NewTrajectory
    | OccupiedCells
)
"""Every record but the header."""


def metadata(header: RunHeader) -> dict[str, str]:
    """The run as MCAP metadata; the utc offset is in whole nanoseconds."""
    return {
        "schema": SCHEMA,
        "run_id": header.run_id,
        "system": header.system,
        "tool_version": header.tool_version,
        "vehicle": header.vehicle,
        "site": header.site,
        "simulated": "yes" if header.simulated else "no",
        "seed": "" if header.seed is None else str(header.seed),
        "utc_offset_ns": str(round(header.utc_offset * 1e9)),
    }


class Scribe:
    """Writes records to the channels of a log. One thread only."""

    def __init__(self, context: Context, header: RunHeader, rates: Rates) -> None:
        self._header = header
        self._offset = round(header.utc_offset * 1e9)
        self._battery, self._gps = Pace(rates.battery), Pace(rates.gps)
        self._posed = float("-inf")
        self._drawn = False
        self._json = {
            topic: Channel(topic, schema=messages.schema(kind), context=context)
            for topic, kind in messages.JSON_TOPICS.items()
        }
        self._fox: Mapping[str, Any] = {
            topic: kind(topic, context=context) for topic, kind in FOXGLOVE_TOPICS.items()
        }

    def write(self, record: TimedRecord) -> None:
        """Log one record under its own time; ValueError when it holds a number that is none."""
        utc = self._offset + round(record.time * 1e9)
        if not self._drawn:
            self.draw_plan(record.time)
        self._dispatch(record, utc)

    def draw_plan(self, time: float) -> None:
        """Log what the mission is, once more where readers join late; `time` on the flight clock.

        The first record does so by itself.
        """
        self._drawn = True
        self._plan(self._offset + round(time * 1e9))

    def _dispatch(self, record: TimedRecord, utc: int) -> None:
        match record:
            case VehicleState():
                self._state(record, utc)
            case DepthFrame():
                self._frame(record, utc)
            case ColourFrame():
                self._log("/camera/colour", forms.colour_image(record, utc), utc)
            case OccupiedCells():
                self._log("/map/occupied", forms.occupied(record, utc), utc)
            case NewTrajectory():
                self._trajectory(record, utc)
            case LogLine():
                self._log("/log", forms.log_line(record, utc), utc)
            case _:
                topic, message = json_form(record)
                self._say(topic, message, utc)

    def _plan(self, utc: int) -> None:
        mission = self._header.mission
        self._log("/plan/waypoints", forms.path(mission.waypoints_site, utc), utc)
        self._log("/plan/spline", forms.spline(mission, utc), utc)
        self._log("/scene", scene(mission.orchard, utc), utc)

    def _state(self, state: VehicleState, utc: int) -> None:
        odometry = messages.Odometry(
            time=state.time,
            position_m=vector(state.position_site),
            velocity_m_s=vector(state.velocity_site),
            site_from_body=vector(state.site_from_body),
            angular_velocity_rad_s=known_vector(state.angular_velocity_body),
            armed=state.armed,
            mode=state.mode.value,
            landed=state.landed.value,
            ready=state.ready,
            not_ready=list(state.not_ready),
            heard=state.heard,
        )
        self._say("/odometry", odometry, utc)
        if state.time > self._posed:  # the flight logs its newest telemetry, so samples repeat
            self._posed = state.time
            self._log("/tf", forms.body_transform(state, utc), utc)
            self._log("/pose", forms.pose(state, utc), utc)
        if self._gps.due(state.time):
            origin = self._header.mission.orchard.origin
            self._log("/gps", forms.location(state, origin, utc), utc)
        if self._battery.due(state.time):
            battery = messages.Battery(
                time=state.time,
                share=known(state.battery_share),
                voltage_v=known(state.battery_voltage),
            )
            self._say("/battery", battery, utc)

    def _frame(self, frame: DepthFrame, utc: int) -> None:
        self._log("/camera/calibration", forms.calibration(frame.camera, utc), utc)
        self._log("/tf", forms.camera_transform(frame.camera, utc), utc)
        self._log("/camera/depth", forms.depth_image(frame, utc), utc)

    def _trajectory(self, record: NewTrajectory, utc: int) -> None:
        curve = messages.Curve(
            time=record.time,
            start=record.trajectory.start,
            interval=record.trajectory.interval,
            control_points_m=vector(record.trajectory.control_points_site.ravel()),
            why=record.why,
        )
        self._say("/trajectory/curve", curve, utc)
        self._log("/trajectory", forms.trajectory_ahead(record, utc), utc)
        self._log("/guide_path", forms.path(record.guide_site, utc), utc)

    def _log(self, topic: str, message: Any, utc: int) -> None:
        self._fox[topic].log(message, log_time=utc)

    def _say(self, topic: str, message: msgspec.Struct, utc: int) -> None:
        self._json[topic].log(msgspec.json.encode(message), log_time=utc)
