"""The depth images of a log, as the camera gave them: for replaying a flight."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from mcap.records import Channel, Metadata, Schema
from mcap_protobuf.decoder import DecoderFactory

from orchard_cli.flightlog.scan import Raw, Scan
from orchard_cli.model.depth import DepthCamera, DepthFrame, d455

IMAGE, CALIBRATION = "/camera/depth", "/camera/calibration"


def depth_frames(path: Path) -> Iterator[DepthFrame]:
    """Every depth image of a log in file order, on the flight clock, as far as the file is whole.

    A log tells a camera's intrinsics; its mounting and its trusted range are the D455's. Images
    before their calibration are left out. Raises InputError when the file is no MCAP.
    """
    schemas: dict[int, Schema] = {}
    decoders: dict[int, tuple[str, Any]] = {}
    offset, camera = 0, None
    for record in Scan(path, (IMAGE, CALIBRATION)):
        match record:
            case Metadata() if record.name == "orchard":
                offset = int(record.metadata.get("utc_offset_ns", "0"))
            case Schema():
                schemas[record.id] = record
            case Channel() if record.topic in (IMAGE, CALIBRATION):
                schema = schemas[record.schema_id]
                decode = DecoderFactory().decoder_for(record.message_encoding, schema)
                decoders[record.id] = (record.topic, decode)
            case Raw() if record.channel_id in decoders:
                topic, decode = decoders[record.channel_id]
                found = decode(record.data)
                if topic == CALIBRATION:
                    camera = _camera(found)
                elif camera is not None:
                    depth = np.frombuffer(found.data, dtype="<u2")
                    depth = depth.reshape(found.height, found.width)
                    yield DepthFrame((record.log_time - offset) / 1e9, depth, camera)


def _camera(calibration: Any) -> DepthCamera:
    fx, _, cx, _, fy, cy, *_ = calibration.K
    size = {"width": calibration.width, "height": calibration.height}
    return replace(d455(), fx=fx, fy=fy, cx=cx, cy=cy, **size)
