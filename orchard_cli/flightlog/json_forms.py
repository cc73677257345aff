"""Records as the JSON messages of the log."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec

from orchard_cli.flightlog import messages
from orchard_cli.flightlog.messages import known, known_vector, vector
from orchard_cli.model.records import PlannerRecord, SafetyRecord, SprayRecord, TruthRecord
from orchard_cli.model.sensors import RadarScan, RangeScan
from orchard_cli.model.vehicle import Setpoint

Spoken = Setpoint | PlannerRecord | SafetyRecord | SprayRecord | TruthRecord | RadarScan | RangeScan
"""What has a topic with a JSON schema of ours."""


def json_form(record: Spoken) -> tuple[str, msgspec.Struct]:
    """The topic of a record, and its message. ValueError when a number in it is none."""
    topic, form = _FORMS[type(record)]
    message: msgspec.Struct = form(record)
    return topic, message


def _setpoint(record: Setpoint) -> messages.Setpoint:
    return messages.Setpoint(
        time=record.time,
        position_m=vector(record.position_site),
        velocity_m_s=known_vector(record.velocity_site),
        acceleration_m_s2=known_vector(record.acceleration_site),
        yaw_rad=record.yaw_site,
        yaw_rate_rad_s=record.yaw_rate,
    )


def _planner(record: PlannerRecord) -> messages.Planner:
    return messages.Planner(
        time=record.time,
        frame_time=record.frame_time,
        decision=record.decision,
        why=record.why,
        blocked_at_m=known(record.blocked_at),
        stages=[messages.Stage(name=n, ms=ms) for n, ms in record.stages_ms.items()],
    )


def _safety(record: SafetyRecord) -> messages.Safety:
    return messages.Safety(
        time=record.time,
        phase=record.phase,
        action=record.action,
        why=record.why,
        faults=list(record.faults),
        tracking_m=msgspec.UNSET if record.tracking is None else record.tracking,
    )


def _spray(record: SprayRecord) -> messages.Spray:
    row = msgspec.UNSET if record.row is None else record.row
    return messages.Spray(
        time=record.time, on=record.on, row=row, why=record.why,
        level=known(record.level), used_l=known(record.used),
    )  # fmt: skip


def _truth(record: TruthRecord) -> messages.Truth:
    return messages.Truth(
        time=record.time,
        position_m=vector(record.position_site),
        velocity_m_s=vector(record.velocity_site),
        site_from_body=vector(record.site_from_body),
        contact=record.contact,
    )


def _radar(scan: RadarScan) -> messages.RadarSweep:
    radar = scan.radar
    return messages.RadarSweep(
        time=scan.time,
        returns=[
            messages.Reflection(range_m=r, azimuth_rad=a, elevation_rad=e, speed_m_s=known(v))
            for r, a, e, v in scan.returns.tolist()
        ],
        range_max_m=radar.range_max,
        width_rad=radar.width,
        height_rad=radar.height,
        rate_hz=radar.rate,
        position_body_m=vector(radar.position_body),
        body_from_radar=vector(radar.body_from_radar.ravel()),
    )


def _ranges(scan: RangeScan) -> messages.Ranges:
    beams = scan.beams
    return messages.Ranges(
        time=scan.time,
        beams=[
            messages.Beam(
                name=name, range_m=known(far), place_body_m=vector(place),
                direction_body=vector(way),
            )
            for name, far, place, way in zip(
                beams.names, scan.ranges, beams.places_body, beams.directions_body, strict=True
            )
        ],
        range_max_m=beams.range_max,
        rate_hz=beams.rate,
    )  # fmt: skip


_FORMS: dict[type, tuple[str, Callable[[Any], msgspec.Struct]]] = {
    Setpoint: ("/setpoint", _setpoint),
    PlannerRecord: ("/planner", _planner),
    SafetyRecord: ("/safety", _safety),
    SprayRecord: ("/spray", _spray),
    TruthRecord: ("/truth", _truth),
    RadarScan: ("/sensors/radar", _radar),
    RangeScan: ("/sensors/range", _ranges),
}
