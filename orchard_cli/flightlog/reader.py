"""MCAP -> FlownLog. Only the topics asked for are decoded."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from mcap.records import Attachment, Channel, Metadata, Schema
from mcap_protobuf.decoder import DecoderFactory

from orchard_cli.errors import Fault, InputError
from orchard_cli.flightlog import messages, records
from orchard_cli.flightlog.messages import JSON_TOPICS
from orchard_cli.flightlog.scan import Raw, Scan
from orchard_cli.flightlog.scribe import SCHEMA
from orchard_cli.model.arrays import Array
from orchard_cli.model.flown import FlownLog

NEEDED = (*JSON_TOPICS, "/log")
"""What metrics are made of; /map/occupied can be asked for besides."""

ROOM = 128 * 2**20
"""bytes of messages besides odometry, truth and setpoints: many hours of them, an hour of maps."""


def read(path: Path | str, topics: Collection[str] | None = None) -> FlownLog:
    """A flight's log, as far as the file is whole; its `notes` say where it was cut or damaged.

    `topics` limits what is decoded (default: NEEDED). Raises InputError when the file cannot be
    read, is no MCAP, or holds no flight of ours.
    """
    path = Path(path)
    wanted = frozenset(NEEDED if topics is None else topics)
    scan = Scan(path, wanted)
    taken = _Taken(wanted)
    for record in scan:
        taken.add(record)
    try:
        return taken.flown(path, scan.end)
    except ValueError as error:
        fault = Fault(str(path), f"does not hold together: {error}", "fly and log again")
        raise InputError(fault) from None


class _Taken:
    """Collects the decoded messages by topic, in file order."""

    def __init__(self, topics: Collection[str]) -> None:
        self._topics = topics
        self._schemas: dict[int, Schema] = {}
        self._decoders: dict[int, tuple[str, Callable[[bytes], Any]]] = {}  # by channel
        self._metadata: dict[str, str] = {}
        self._attachments: dict[str, bytes] = {}
        self._messages: dict[str, list[Any]] = {topic: [] for topic in topics}
        self._rows = {
            "/odometry": records.motion_rows(),
            "/truth": records.motion_rows(),
            "/setpoint": records.setpoint_rows(),
        }
        self._touched = 0  # messages of /truth that are kept whole: the first, the first contact
        self._unreadable: Counter[str] = Counter()
        self._room = ROOM
        self._crowded = False

    def add(self, record: Any) -> None:
        match record:
            case Raw():
                self._message(record)
            case Schema():
                self._schemas.setdefault(record.id, record)
            case Channel():
                self._channel(record)
            case Attachment():
                self._attachments[record.name] = record.data
            case Metadata() if record.name == "orchard":
                self._metadata = record.metadata

    def _channel(self, channel: Channel) -> None:
        if channel.topic not in self._topics or channel.id in self._decoders:
            return
        try:
            self._decoders[channel.id] = (channel.topic, self._decoder(channel))
        except Exception:  # a damaged schema: protobuf raises many kinds
            self._unreadable[channel.topic] += 1

    def _decoder(self, channel: Channel) -> Any:
        if channel.topic in JSON_TOPICS:
            return msgspec.json.Decoder(JSON_TOPICS[channel.topic]).decode
        schema = self._schemas[channel.schema_id]
        return DecoderFactory().decoder_for(channel.message_encoding, schema)

    def _message(self, message: Raw) -> None:
        if message.channel_id not in self._decoders:
            return
        topic, decode = self._decoders[message.channel_id]
        try:
            found = decode(message.data)
        except Exception:  # of another version or damaged: protobuf and msgspec raise many kinds
            self._unreadable[topic] += 1
            return
        if topic in self._rows:
            self._rows[topic].add(found)
            if topic != "/truth" or not self._tells_more(found):
                return
        self._room -= len(message.data)
        self._crowded = self._crowded or self._room < 0
        if not self._crowded:
            self._messages[topic].append((message.log_time, found))

    def _tells_more(self, truth: messages.Truth) -> bool:
        """Whether contacts are looked for, and the first that is made."""
        looked = isinstance(truth.contact, str)
        if looked and self._touched < (2 if truth.contact else 1):
            self._touched = 2 if truth.contact else 1
            return True
        return False

    def flown(self, path: Path, end: str) -> FlownLog:
        """Everything collected as one noun. Raises InputError when there is no flight in it."""
        if self._metadata.get("schema") != SCHEMA:
            found = self._metadata.get("schema")
            what = f"is of another kind, {found}" if found else "holds no flight of orchard"
            reason = f" ({end})" if end else ""
            raise InputError(Fault(str(path), what + reason, "name a log of `orchard fly`"))
        got = {topic: self._messages.get(topic, []) for topic in (*NEEDED, "/map/occupied")}
        bodies = {topic: [body for _, body in messages] for topic, messages in got.items()}
        offset = int(self._metadata.get("utc_offset_ns", "0"))
        odometry, backwards = records.track(self._rows["/odometry"])
        truth, _ = records.track(self._rows["/truth"])
        return FlownLog(
            file=path.name,
            metadata=self._metadata,
            attachments=self._attachments,
            odometry=odometry,
            truth=truth if len(truth.times) else None,
            contacts=records.contacts(bodies["/truth"]),
            commands=records.commands(self._rows["/setpoint"]),
            battery_times=np.array([b.time for b in bodies["/battery"]]),
            battery_shares=np.array([records.number(b.share) for b in bodies["/battery"]]),
            planner=tuple(records.planner(b) for b in bodies["/planner"]),
            safety=tuple(records.safety(b) for b in bodies["/safety"]),
            spray=tuple(records.spray(b) for b in bodies["/spray"]),
            radar=tuple(records.radar(b) for b in bodies["/sensors/radar"]),
            ranges=tuple(records.ranges(b) for b in bodies["/sensors/range"]),
            trajectories=tuple(records.new_trajectory(b) for b in bodies["/trajectory/curve"]),
            maps=tuple(records.cells(b, t, offset) for t, b in got["/map/occupied"]),
            lines=tuple(records.line(b, t, offset) for t, b in got["/log"]),
            notes=self._notes(end, odometry.times, backwards),
        )

    def _notes(self, end: str, times: Array, backwards: int) -> tuple[str, ...]:
        notes = []
        if end:
            span = f"{times[-1] - times[0]:.1f} s of flight" if len(times) else "no flight"
            notes.append(f"read up to the last whole chunk, {span}: {end}")
        if self._crowded:
            notes.append(f"only the first {ROOM // 2**20} MB of messages are read")
        if backwards:
            notes.append(f"{backwards} odometry messages out of time order are left out")
        notes += [
            f"{rows.impossible} messages of {topic} tell impossible numbers and are left out"
            for topic, rows in self._rows.items()
            if rows.impossible
        ]
        notes += [
            f"{count} messages of {topic} cannot be read"
            for topic, count in sorted(self._unreadable.items())
        ]
        return tuple(notes)
